/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ryusa as a library: make a simulation from a config, step it, look at it. All values SI.
 *
 *     ry_config config;
 *     ry_error error = {0};
 *     if (ry_config_load(&config, "scene.yaml", NULL, 0, &error) != RY_OK) { puts(error.text); return 2; }
 *     ry_sim *sim = ry_sim_create(&config, 1, &error);
 *     ry_sim_step(sim, 1000, &error);
 *     printf("q* = %g\n", ry_sim_sample(sim).q_star);
 *     ry_sim_free(sim);
 *     ry_config_free(&config);
 *
 * A program makes as many simulations as it likes; one simulation is used by one thread at a time. */
#ifndef RYUSA_H
#define RYUSA_H

#include "ryusa/config.h"
#include "ryusa/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ry_sim ry_sim;

/* Builds the first state of a resolved config. threads 0: as many as pay. NULL on failure. */
RY_API ry_sim *ry_sim_create(const ry_config *config, int threads, ry_error *error);
RY_API void ry_sim_free(ry_sim *sim);

/* Takes n steps. RY_UNPHYSICAL: what, where and when; the state is then that of the last good check, at
 * most 256 steps earlier (with more than 200 000 grains it stays as it is, to save memory). */
RY_API ry_status ry_sim_step(ry_sim *sim, long long n, ry_error *error);

/* Read-only views; pointers stay valid until the next call that steps or frees. Arrays of grains are
 * in storage order: entry k belongs to grain id[k]. */
typedef struct ry_view {
    int n;
    long long step;
    double time; /* [s] */
    const int32_t *id, *image;
    const uint8_t *fixed;
    const double *x, *z, *vx, *vz, *spin, *radius, *density;
    int nz;          /* cells of the fluid column; 0: none */
    double dz;       /* [m] */
    const double *u; /* velocity of the fluid, nz values [m/s] */
} ry_view;
/* A simulation is for one thread at a time, to look at it included: what is asked for is completed then. */
RY_API ry_view ry_sim_view(const ry_sim *sim);

/* What the series of a result file hold, at this instant. */
typedef struct ry_sample {
    double q_star;         /* [1] */
    double q_b;            /* sum of V u / (L d) [m^2/s] */
    double bed_level;      /* as of the fluid's last advance; NAN without fluid [m] */
    double kinetic_energy; /* of translation and spin, with added mass [J] */
    double gravity_energy; /* buoyant weight x height [J] */
    double elastic_normal, elastic_tangential; /* [J] */
    double fluid_work;     /* since step 0 [J] */
    double loss_impact, loss_dashpot, loss_friction, loss_opening; /* since step 0 [J] */
    double integration;    /* what the time stepping gained (+) or lost (-) since step 0 [J] */
} ry_sample;
RY_API ry_sample ry_sim_sample(ry_sim *sim);

/* One number for all bits of the state. */
RY_API unsigned long long ry_sim_hash(ry_sim *sim);

/* Runs a config to its end, as `ryusa run` does. */
typedef struct ry_run_options {
    const char *output; /* result file; NULL: none */
    int threads;        /* 0: as many as pay */
    int resume;         /* go on from output(.part) */
    int force;          /* overwrite an existing output */
    /* Called about ten times a second from the running thread, NULL: never. A return other than 0 asks
     * the run to stop: it saves and returns RY_STOPPED. */
    int (*progress)(void *data, long long step, long long last_step, double steps_per_second);
    void *data;
} ry_run_options;
typedef struct ry_run_result {
    long long steps;          /* taken by this call */
    double wall_seconds;      /* of the step loop */
    double q_star, q_star_error, autocorrelation_time;
    double equilibration;     /* the time before which samples were cut [s] */
    long long samples;        /* after the cut */
    int stopped_early;        /* stop.flux_error was reached */
    unsigned long long hash;  /* of the final state */
    char note[300];           /* what the user should know: "was finished already", "started anew because ..." */
} ry_run_result;
RY_API ry_status ry_run(const ry_config *config, const ry_run_options *options,
                        ry_run_result *result, ry_error *error);

/* Text for people: what `ryusa show` and `ryusa info` print. `write` is called with pieces of text. */
typedef void ry_write_fn(void *data, const char *text);
RY_API ry_status ry_describe_scene(const ry_config *config, ry_write_fn *write, void *data, ry_error *error);
RY_API ry_status ry_describe_file(const char *path, ry_write_fn *write, void *data, ry_error *error);

/* "major.minor.patch" */
RY_API const char *ry_version(void);

#ifdef __cplusplus
}
#endif
#endif
