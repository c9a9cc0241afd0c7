/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors */
#include "study/verify.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "study/verify_private.h"

enum { WIDTH = 100, MOST_ROWS = 200 };

const ry_variant ry_variants[RY_VARIANTS] = {
    [RY_V_C_TENSION] = {RY_LAW_CUNDALL_TENSION, RY_MAPPING_USUAL, "C", "cundall-tension"},
    [RY_V_C] = {RY_LAW_CUNDALL, RY_MAPPING_EXACT, "C", "cundall"},
    [RY_V_T] = {RY_LAW_TANAKA, RY_MAPPING_USUAL, "T", "tanaka"},
    [RY_V_F] = {RY_LAW_FUJIOKA1, RY_MAPPING_USUAL, "F", "fujioka-1"},
    [RY_V_P_PRINTED] = {RY_LAW_FUJIOKA2_PRINTED, RY_MAPPING_USUAL, "P", "fujioka-2-printed"},
    [RY_V_P] = {RY_LAW_FUJIOKA2, RY_MAPPING_USUAL, "P", "fujioka-2"},
    [RY_V_ENERGY] = {RY_LAW_ENERGY, RY_MAPPING_USUAL, "-", "energy"},
};

static const struct {
    const char *word, *text;
    ry_status (*run)(ry_verify_run *run, ry_error *error);
} cases[RY_VERIFY_CASES] = {
#define RY_CASE(name, word, text) {word, text, ry_verify_##name},
    RY_LIST_verify_case(RY_CASE)
#undef RY_CASE
};

const char *ry_verify_case_word(int index)
{
    return cases[index].word;
}

const char *ry_verify_case_text(int index)
{
    return cases[index].text;
}

/* --- text ------------------------------------------------------------------------------------- */

/* Words from `text` as lines that begin after `indent` columns. */
static void say_wrapped(const ry_verify_run *run, int indent, const char *text)
{
    while (*text) {
        size_t length = strlen(text);
        const size_t room = (size_t)(WIDTH - indent);
        if (length > room) {
            for (length = room; length > 0 && text[length] != ' ';) {
                length--;
            }
            length = length > 0 ? length : room;
        }
        ry_verify_say(run, "%*s%.*s\n", indent, "", (int)length, text);
        text += length;
        text += *text == ' ';
    }
}

ry_verify_path ry_verify_at(const ry_verify_run *run, const char *law, const char *name)
{
    ry_verify_path path;
    snprintf(path.text, sizeof path.text, "%s/%s%s%s", cases[run->current].word, law,
             *law && *name ? "/" : "", name);
    return path;
}

/* --- claims ----------------------------------------------------------------------------------- */

/* All claims so far, for the group /claims of the file. */
struct ry_rows {
    int n;
    char what[MOST_ROWS][100];
    const char *word[MOST_ROWS], *verdict[MOST_ROWS], *why[MOST_ROWS];
    double value[MOST_ROWS], reference[MOST_ROWS], low[MOST_ROWS], high[MOST_ROWS];
};

static const char *judge(ry_verify_run *run, const ry_claim *claim)
{
    const int between = claim->value >= claim->low && claim->value <= claim->high;
    const int holds = isnan(claim->reference)
                          ? between
                          : fabs(claim->value - claim->reference) <= claim->tolerance;
    if (holds) {
        run->summary.ok++;
        return "ok";
    }
    if (between && claim->why != NULL) {
        run->summary.differs++;
        return "differs";
    }
    run->summary.failed++;
    return "FAILED";
}

/* What the value is held against: a number, or where it must lie. */
static void print_reference(char *text, size_t size, const ry_claim *claim)
{
    if (claim->reference == 0.0 && claim->tolerance > 0.0) {
        snprintf(text, size, "< %.4g", claim->tolerance);
    } else if (!isnan(claim->reference)) {
        snprintf(text, size, "%.*g", fabs(claim->reference) < 1e4 ? 7 : 4, claim->reference);
    } else if (isfinite(claim->low) && isfinite(claim->high)) {
        snprintf(text, size, "%.4g..%.4g", claim->low, claim->high);
    } else if (isfinite(claim->low)) {
        snprintf(text, size, "> %.4g", claim->low);
    } else {
        snprintf(text, size, "< %.4g", claim->high);
    }
}

void ry_verify_claim(ry_verify_run *run, ry_claim claim, const char *format, ...)
{
    char what[100], reference[40];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    const char *const verdict = judge(run, &claim);
    const int is_ok = strcmp(verdict, "ok") == 0;
    print_reference(reference, sizeof reference, &claim);
    const int digits = fabs(claim.reference) > 0.0 && fabs(claim.reference) < 1e4 ? 7 : 4;
    ry_verify_say(run, "  %-8s %-64s %10.*g %13s\n", verdict, what, digits, claim.value, reference);
    if (!is_ok && claim.why != NULL) {
        say_wrapped(run, 11, claim.why);
    }
    ry_rows *const rows = run->rows;
    if (rows->n < MOST_ROWS) {
        const int k = rows->n++;
        snprintf(rows->what[k], sizeof rows->what[k], "%s", what);
        rows->word[k] = cases[run->current].word;
        rows->verdict[k] = verdict;
        rows->why[k] = is_ok || claim.why == NULL ? "" : claim.why;
        rows->value[k] = claim.value;
        rows->reference[k] = claim.reference;
        rows->low[k] = claim.low;
        rows->high[k] = claim.high;
    }
}

static void write_claims(ry_verify_run *run)
{
    const ry_rows *const rows = run->rows;
    const char *what[MOST_ROWS];
    for (int k = 0; k < rows->n; k++) {
        what[k] = rows->what[k];
    }
    ry_table_file *const f = run->file;
    ry_table_file_texts(f, "claims/case", "case", rows->n, rows->word);
    ry_table_file_texts(f, "claims/what", "what is claimed", rows->n, what);
    ry_table_file_texts(f, "claims/verdict", "ok, differs (for a known reason) or FAILED", rows->n,
                        rows->verdict);
    ry_table_file_texts(f, "claims/why", "why it differs", rows->n, rows->why);
    ry_table_file_numbers(f, "claims/value", "1", "measured", rows->n, rows->value);
    ry_table_file_numbers(f, "claims/reference", "1", "exact or printed value; NAN: a range",
                          rows->n, rows->reference);
    ry_table_file_numbers(f, "claims/low", "1", "lowest value expected", rows->n, rows->low);
    ry_table_file_numbers(f, "claims/high", "1", "highest value expected", rows->n, rows->high);
}

/* --- all cases -------------------------------------------------------------------------------- */

static ry_status run_cases(ry_verify_run *run, ry_error *error)
{
    const unsigned wanted = run->options->cases ? run->options->cases : ~0u;
    for (int k = 0; k < RY_VERIFY_CASES; k++) {
        if (wanted >> k & 1u) {
            run->current = k;
            ry_verify_say(run, "%s: %s\n", cases[k].word, cases[k].text);
            RY_TRY(cases[k].run(run, error));
            ry_verify_say(run, "\n");
        }
    }
    return RY_OK;
}

static void write_head(const ry_verify_run *run)
{
    ry_table_file_set_text(run->file, "/", "source",
                           "S. Fujioka and S. Ushijima (2005): An evaluation method of normal "
                           "contact force with energy conservation in distinct element method");
    ry_table_file_set_number(run->file, "/", "quick", run->options->quick);
}

ry_status ry_verify(const ry_verify_options *options, ry_verify_summary *summary, ry_error *error)
{
    const double start = ry_clock();
    ry_verify_run run = {.options = options, .rows = calloc(1, sizeof(ry_rows))};
    if (run.rows == NULL) {
        return ry_no_memory(error, sizeof(ry_rows));
    }
    ry_status status =
        ry_table_file_create(&run.file, options->output, "ryusa verify", options->force, error);
    if (status == RY_OK) {
        write_head(&run);
        status = run_cases(&run, error);
        if (status == RY_OK) {
            write_claims(&run);
            status = ry_table_file_finish(run.file, error);
        } else {
            ry_table_file_discard(run.file);
        }
    }
    free(run.rows);
    run.summary.seconds = ry_clock() - start;
    *summary = run.summary;
    return status;
}
