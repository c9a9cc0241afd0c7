/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The result file of a run that is killed at any moment, or whose disk is full: what was flushed
 * stays readable, and the run that goes on ends with the same file. ctest: slow */
#include <sys/mount.h>
#include <sys/resource.h>

#include "io_run.h"

/* The run is killed at any moment, again and again, each time taken up, until it is whole. */
static void test_kill(void **unused)
{
    (void)unused;
    const char *const kills_text = getenv("RY_KILLS");
    const int kills = kills_text != NULL ? atoi(kills_text) : 40;
    plan of = {.path = in_folder("killed.h5"), .resume = 1, .flush_every = 50};
    uint64_t random = 88172645463325252u;
    int killed = 0;
    for (int k = 0; k < kills && !exists("killed.h5"); ++k) {
        const pid_t child = fork();
        if (child == 0) {
            _exit((int)run(&of));
        }
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        usleep((unsigned)(2000 + random % 60000));
        kill(child, SIGKILL);
        int status = 0;
        waitpid(child, &status, 0);
        killed += WIFSIGNALED(status);
        assert_true(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
    }
    of.flush_every = 1000;
    must(&of);
    assert_true(killed > 3);
    assert_same(of.path);
    assert_false(exists("killed.h5.part") || exists("killed.h5.part.journal"));
}

/* A file may not grow beyond a limit, which moves from almost nothing to almost enough. */
static void test_limit(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("limit.h5"), .resume = 1, .flush_every = 500};
    for (rlim_t limit = 10000; limit < 700000; limit += 23456) {
        const pid_t child = fork();
        if (child == 0) {
            const struct rlimit most = {limit, limit};
            signal(SIGXFSZ, SIG_IGN);
            setrlimit(RLIMIT_FSIZE, &most);
            const ry_status status = run(&of);
            if (status != RY_OK && strstr(of.error.text, "File too large") == NULL) {
                print_message("%s\n", of.error.text);
                _exit(99);
            }
            _exit((int)status);
        }
        int status = 0;
        waitpid(child, &status, 0);
        assert_true(WIFEXITED(status));
        assert_true(WEXITSTATUS(status) == RY_BAD_FILE || WEXITSTATUS(status) == RY_OK);
        if (have_h5py() && exists("limit.h5.part")) {
            assert_int_equal(python("opens", in_folder("limit.h5.part"), NULL), 0);
        }
    }
    must(&of);
    assert_same(of.path);
}

/* A disk that fills up, and is given more room then. */
static void test_disk_full(void **unused)
{
    (void)unused;
    const char *const disk = in_folder("disk");
    if (mkdir(disk, 0700) != 0 || mount("tmpfs", disk, "tmpfs", 0, "size=100k") != 0) {
        skip();
    }
    plan of = {.path = in_folder("disk/full.h5"), .resume = 1, .flush_every = 500};
    int full = 0;
    for (int size = 120; size < 2000; size += 40) {
        char options[40];
        snprintf(options, sizeof options, "size=%dk", size);
        assert_int_equal(mount("tmpfs", disk, "tmpfs", MS_REMOUNT, options), 0);
        of.path = in_folder("disk/full.h5");
        if (run(&of) == RY_OK) {
            break;
        }
        ++full;
        assert_non_null(strstr(of.error.text, "No space left on device"));
        if (have_h5py() && exists("disk/full.h5.part")) {
            assert_int_equal(python("opens", in_folder("disk/full.h5.part"), NULL), 0);
        }
    }
    of.path = in_folder("disk/full.h5");
    const int made = exists("disk/full.h5");
    if (made) {
        assert_same(of.path);
    }
    umount(disk);
    assert_true(made && full > 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kill),
        cmocka_unit_test(test_limit),
        cmocka_unit_test(test_disk_full),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
