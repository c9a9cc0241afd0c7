#include "study/bench_private.h"
ry_status ry_bench_accuracy(ry_bench_run *run, ry_error *error)
{
    (void)run;
    (void)error;
    return RY_OK;
}
