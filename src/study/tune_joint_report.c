/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The report of a joint fit: the constants, and which of them the data constrain. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "study/tune_private.h"

#define say ry_tune_say

/* Exponents below this part of the largest one are left out of a direction's name. */
#define LEAST_EXPONENT 0.2

static const char *short_name(const ry_tune_axis *axis)
{
    const char *const dot = strchr(axis->path, '.');
    return dot != NULL ? dot + 1 : axis->path;
}

static const char *verdict_of(const ry_verdict *v, int k)
{
    const int below = v->low[k] > -1.0, above = v->high[k] < 1.0;
    return below && above ? "constrained"
           : below        ? "bounded from below only"
           : above        ? "bounded from above only"
                          : "NOT IDENTIFIABLE";
}

static void constants_table(const ry_tune_run *run)
{
    const ry_tune_joint *const j = &run->joint;
    say(run, "\n  %-22s %-18s %8s   %-18s\n", "constant", "bounds", "best", "95 %");
    for (int k = 0; k < j->n_axes; k++) {
        char bounds[40], interval[40];
        snprintf(bounds, sizeof bounds, "%.4g to %.4g", j->axis[k].low, j->axis[k].high);
        snprintf(interval, sizeof interval, "%.3g to %.3g", j->low[k], j->high[k]);
        say(run, "  %-22s %-18s %8.3g   %-18s %s\n", j->axis[k].path, bounds, j->best[k], interval,
            verdict_of(&j->verdict, k));
    }
}

/* The direction as a product of powers: what stays the same across it. In ln of the constants, an axis
 * counts by its half width. */
static void name_direction(const ry_tune_joint *j, int d, char *out, size_t size, int *members)
{
    double power[RY_RESPONSE_INPUTS], largest = 0.0;
    size_t used = 0;
    for (int k = 0; k < j->n_axes; k++) {
        power[k] = j->verdict.vector[d][k] * 0.5 * log(j->axis[k].high / j->axis[k].low);
        largest = fabs(power[k]) > fabs(largest) ? power[k] : largest;
    }
    *members = 0;
    out[0] = '\0';
    for (int k = 0; k < j->n_axes && used < size; k++) {
        const double part = power[k] / largest;
        if (fabs(part) >= LEAST_EXPONENT) {
            used += (size_t)snprintf(out + used, size - used, "%s%s^%.2g", *members > 0 ? " " : "",
                                     short_name(&j->axis[k]), part);
            ++*members;
        }
    }
}

static void directions(const ry_tune_run *run)
{
    const ry_tune_joint *const j = &run->joint;
    const ry_verdict *const v = &j->verdict;
    int flat = 0;
    for (int d = 0; d < j->n_axes; d++) {
        flat += v->flat[d];
    }
    say(run, "\n  A constant is known as its 95 %% say. Of their combinations the data constrain %d of %d\n"
             "  (eigenvectors of the Fisher information; rise: of the misfit within the bounds; below %.3g it is\n"
             "  within its noise, and the direction flat):\n",
        j->n_axes - flat, j->n_axes, v->threshold);
    say(run, "  information     rise    along\n");
    for (int d = 0; d < j->n_axes; d++) {
        char name[300];
        int members;
        name_direction(j, d, name, sizeof name, &members);
        say(run, "  %11.3g %8.3g    %s%s\n", v->value[d], v->rise[d], name, v->flat[d] ? "  FLAT" : "");
        if (v->flat[d]) {
            say(run, "                         %s\n",
                members > 1 ? "confounded: moved together like this they change nothing that is seen"
                            : "what it does to q* is less than the noise");
        }
    }
}

static void surfaces(const ry_tune_run *run)
{
    const ry_tune_joint *const j = &run->joint;
    say(run, "\n  ln(q*/target), left-out candidates are off by (rms):\n   ");
    for (int i = 0; i < j->aim.outputs; i++) {
        say(run, " theta %.3g: %.2f%s", run->fit.theta[i], j->aim.response[i].cross,
            i + 1 < j->aim.outputs ? "," : "\n");
    }
}

void ry_tune_report_joint(const ry_tune_run *run)
{
    const ry_tune_joint *const j = &run->joint;
    const ry_tune_fit *const fit = &run->fit;
    ry_tune_report_head(run);
    say(run, "\nJoint fit of %d constants: %d candidates all over the bounds, %d where the best may be, %d of use;\n"
             "  the same packings for each. Quadratic surfaces in ln of the constants.\n",
        j->n_axes, j->first, j->n - j->first, j->good);
    constants_table(run);
    directions(run);
    surfaces(run);
    say(run, "\nFlux with the best constants, %d packing%s\n", fit->seeds, fit->seeds == 1 ? "" : "s");
    ry_tune_report_theta(run);
    ry_tune_report_spread(run);
    ry_tune_report_flux(run, &fit->best, "best");
    ry_tune_report_reach(run, "other constants within the bounds meet it, not these");
    if (run->wish->quick) {
        say(run, "\n--quick: few candidates and short runs; no numbers to rely on\n");
    }
    say(run, "\nresult  %s, scene with the constants %s; %.0f s\n", run->wish->output, run->yaml_path,
        ry_clock() - run->started);
}
