/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * A sweep and its cases as texts and as scenes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/text.h"
#include "config/keys.h"
#include "config/particle.h"
#include "study/sweep_private.h"

/* --- what a case is ----------------------------------------------------------------------------- */

static int seed_of(const ry_sweep_run *run, int index)
{
    return ry_random_replica(run->base.grains_seed, index % run->file.replicas);
}

char *ry_sweep_case_text(const ry_sweep_run *run, int index)
{
    const ry_sweep_file *const f = &run->file;
    const int point = index / f->replicas;
    char *text = strdup("");
    for (int k = 0; k < f->n_axes && text != NULL; k++) {
        char *const longer = ry_text_print("%s%s%s=%s", text, k > 0 ? ", " : "", f->axis[k].path,
                                           ry_sweep_file_value(f, point, k));
        free(text);
        text = longer;
    }
    if (f->replicas > 1 && text != NULL) {
        char *const longer = ry_text_print("%s%sgrains.seed=%d", text, f->n_axes > 0 ? ", " : "",
                                           seed_of(run, index));
        free(text);
        text = longer;
    }
    return text;
}

ry_status ry_sweep_case_config(const ry_sweep_run *run, int index, ry_config *config,
                               ry_error *error)
{
    const ry_sweep_file *const f = &run->file;
    const int n = f->n_axes + (f->replicas > 1);
    char **const text = calloc((size_t)n + 1, sizeof *text);
    int good = text != NULL;
    for (int k = 0; k < n && good; k++) {
        text[k] = k < f->n_axes ? ry_text_print("%s=%s", f->axis[k].path,
                                                ry_sweep_file_value(f, index / f->replicas, k))
                                : ry_text_print("grains.seed=%d", seed_of(run, index));
        good = text[k] != NULL;
    }
    *config = (ry_config){0};
    const ry_status status = good ? ry_config_parse(config, run->base.text, run->base.path,
                                                    (const char *const *)text, n, error)
                                  : ry_no_memory(error, (size_t)n);
    for (int k = 0; k < n && text != NULL; k++) {
        free(text[k]);
    }
    free(text);
    return status;
}

/* --- the sweep as lines, to be compared at --resume --------------------------------------------- */

static int is_varied(const ry_sweep_run *run, int key)
{
    for (int k = 0; k < run->file.n_axes; k++) {
        if (run->file.axis[k].key == key) {
            return 1;
        }
    }
    return 0;
}

/* With the digits that it needs. */
static void print_number(FILE *out, const ry_parameter *p)
{
    char text[40];
    snprintf(text, sizeof text, "%.15g", p->number);
    if (strtod(text, NULL) != p->number) {
        snprintf(text, sizeof text, "%.17g", p->number);
    }
    fprintf(out, "%s.%s = %s\n", p->section, p->key, text);
}

/* Those that stand in the scene number by number, those of a table as a whole. */
static void describe_particles(const ry_config *config, FILE *out)
{
    for (int k = 0, n = 1; k < config->n_particles; k += n, n = 1) {
        const ry_particle *const p = &config->particles[k];
        while (p->table > 0 && k + n < config->n_particles && p[n].table == p->table) {
            n++;
        }
        if (p->table > 0) {
            fprintf(out, "particles[%d to %d] = %d grains of a table, hash %016llx\n", k, k + n - 1, n,
                    (unsigned long long)ry_particle_hash(RY_HASH_START, p, n));
            continue;
        }
        fprintf(out, "particles[%d] =", k);
        for (int j = 0; j < RY_PARTICLE_NUMBERS; j++) {
            fprintf(out, " %.17g", ry_particle_get(p, j));
        }
        fprintf(out, "\n");
    }
}

static void describe_scene(const ry_sweep_run *run, FILE *out)
{
    ry_parameter p;
    for (int k = 0; ry_config_parameter(&run->base, k, &p); k++) {
        const int free_to_change = strcmp(p.section, "numerics") == 0 ||
                                   k == RY_KEY_output_checkpoint || is_varied(run, k);
        if (!free_to_change && p.type == 'c') {
            fprintf(out, "%s.%s = %s\n", p.section, p.key, p.word);
        } else if (!free_to_change) {
            print_number(out, &p);
        }
    }
    fprintf(out, "output.fields = %u\n", run->base.output_fields);
    describe_particles(&run->base, out);
}

char *ry_sweep_describe(const ry_sweep_run *run)
{
    const ry_sweep_file *const f = &run->file;
    char *text = NULL;
    size_t size = 0;
    FILE *const out = open_memstream(&text, &size);
    if (out == NULL) {
        return NULL;
    }
    for (int k = 0; k < f->n_axes; k++) {
        char *const axis = ry_sweep_points_describe(&f->axis[k]);
        fprintf(out, "vary %s = %s\n", f->axis[k].path, axis != NULL ? axis : "");
        free(axis);
    }
    fprintf(out, "sample = %s\nsamples = %d\nreplicas = %d\nseed = %d\n", ry_sweep_file_sampling(f),
            f->samples, f->replicas, f->seed);
    describe_scene(run, out);
    if (fclose(out) != 0) {
        free(text);
        return NULL;
    }
    return text;
}
