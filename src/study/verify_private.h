/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What the cases of `ryusa verify` share: the laws with their constants, text, claims, the file. */
#ifndef RY_STUDY_VERIFY_PRIVATE_H
#define RY_STUDY_VERIFY_PRIVATE_H

#include <math.h>

#include "base/text.h"
#include "io/table_file.h"
#include "study/verify.h"

/* Section 5.1 of the paper. */
#define RY_PAPER_DIAMETER 225.0 /* [m]; the unit of lengths, L */
#define RY_PAPER_GRAVITY 9.8    /* [m/s^2] */
#define RY_PAPER_DENSITY 1.0    /* [kg/m^3] */
#define RY_PAPER_E 0.7
#define RY_PAPER_KEPT (RY_PAPER_E * RY_PAPER_E)
#define RY_PAPER_STEP 1e-3   /* [s] */
#define RY_PAPER_HEIGHT 0.01 /* of the sphere's lowest point [L] */
#define RY_PAPER_SPEED 1e5   /* of the fast bounce [m/s] */

/* Not in the paper; found from its Table 2 (case `steps`): a = k dt^2/m_r of the linear spring, and
 * Hertz' coefficient, f = -a (d/L)^1.5 L. */
#define RY_FOUND_STEP_RATIO 0.104
#define RY_FOUND_HERTZ 4.6

/* The laws in the order of the tables. Of C both forms: with a dashpot that pulls, as the paper has it,
 * and without; of P both: as printed, and corrected. */
typedef struct ry_variant {
    ry_law law;
    ry_mapping mapping; /* e -> dashpot; exact for the C that does not pull */
    const char *letter; /* of the paper */
    const char *name;   /* as in a scene file */
} ry_variant;
enum { RY_V_C_TENSION, RY_V_C, RY_V_T, RY_V_F, RY_V_P_PRINTED, RY_V_P, RY_V_ENERGY, RY_VARIANTS };
extern const ry_variant ry_variants[RY_VARIANTS];

typedef struct ry_rows ry_rows;

typedef struct ry_verify_run {
    const ry_verify_options *options;
    ry_table_file *file;
    int current; /* case */
    ry_rows *rows;
    ry_verify_summary summary;
} ry_verify_run;

#define ry_verify_say(run, ...) ry_text_say((run)->options->write, (run)->options->data, __VA_ARGS__)

/* One statement and its verdict: "ok" if value is within `tolerance` of `reference` (where there is
 * none, NAN: within low .. high), "differs" if not, but it lies in low .. high, where `why` tells
 * that it must; else "FAILED". */
typedef struct ry_claim {
    double value, reference, tolerance, low, high;
    const char *why; /* NULL: no difference is expected */
} ry_claim;
__attribute__((format(printf, 3, 4))) void ry_verify_claim(ry_verify_run *run, ry_claim claim,
                                                           const char *format, ...);

/* "case/law/name", for the file. */
typedef struct ry_verify_path {
    char text[160];
} ry_verify_path;
ry_verify_path ry_verify_at(const ry_verify_run *run, const char *law, const char *name);

/* The cases. */
#define RY_CASE_FUNCTION(name, word, text) \
    ry_status ry_verify_##name(ry_verify_run *run, ry_error *error);
RY_LIST_verify_case(RY_CASE_FUNCTION)
#undef RY_CASE_FUNCTION

#endif
