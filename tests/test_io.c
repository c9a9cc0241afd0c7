/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The result file: what it holds, going on with it, and what is refused. */
#include "io_run.h"

static void refused(plan *of, ry_status status, const char *word)
{
    assert_int_equal(run(of), status);
    if (strstr(of->error.text, word) == NULL) {
        fail_msg("'%s' does not say '%s'", of->error.text, word);
    }
}

static void test_hash(void **unused)
{
    (void)unused;
    ry_state a = first_state(), b = first_state();
    a.step = b.step = 300;
    fill_contacts(&a);
    fill_contacts(&b);
    assert_true(ry_state_hash(&a) == ry_state_hash(&b));
#define SWAP(type, name, unit, text)         \
    {                                        \
        const type kept = b.grains.name[4];  \
        b.grains.name[4] = b.grains.name[9]; \
        b.grains.name[9] = kept;             \
    }
    RY_GRAIN_FIELDS(SWAP)
    assert_true(ry_state_hash(&a) == ry_state_hash(&b));
#define CHANGE(type, name, unit, text)                     \
    b.grains.name[5] = (type)(b.grains.name[5] + (type)1); \
    assert_true(ry_state_hash(&a) != ry_state_hash(&b));   \
    b.grains.name[5] = (type)(b.grains.name[5] - (type)1);
    RY_GRAIN_FIELDS(CHANGE)
#undef CHANGE
    ry_state_free(&b);
    b = first_state();
    b.step = 300;
    fill_contacts(&b);
#define CHANGE(type, name, unit, text)                         \
    b.contacts.name[1] = (type)(b.contacts.name[1] + (type)1); \
    assert_true(ry_state_hash(&a) != ry_state_hash(&b));
    RY_CONTACT_FIELDS(CHANGE)
    ry_state_free(&a);
    ry_state_free(&b);
}

static void test_layout(void **unused)
{
    (void)unused;
    const char *const path = whole();
    assert_false(exists("whole.h5.part"));
    assert_false(exists("whole.h5.part.journal"));
    assert_true(exists("whole.xdmf"));
    if (!have_h5py()) {
        skip();
    }
    assert_int_equal(python("layout", path, NULL), 0);
    assert_int_equal(python("xdmf", path, NULL), 0);
}

static void test_resume(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("resumed.h5"), .resume = 1, .flush_every = 700};
    for (long long until = 1234; until < 9900; until += 1111) {
        of.until = until;
        must(&of);
        assert_true(exists("resumed.h5.part") && !exists("resumed.h5"));
        assert_int_equal(of.found, until > 1234);
    }
    of.until = 0;
    must(&of);
    assert_same(of.path);
}

static void test_fallback(void **unused)
{
    (void)unused;
    if (!have_h5py()) {
        skip();
    }
    plan of = {.path = in_folder("spoilt.h5"), .flush_every = 1000, .until = 3500};
    must(&of);
    assert_int_equal(python("spoil", in_folder("spoilt.h5.part"), "b"), 0);
    of.resume = 1;
    must(&of);
    assert_int_equal(of.found, 1);
    of.until = 4500;
    must(&of);
    assert_int_equal(python("spoil", in_folder("spoilt.h5.part"), "a"), 0);
    assert_int_equal(python("spoil", in_folder("spoilt.h5.part"), "b"), 0);
    refused(&of, RY_BAD_FILE, "damaged");
}

static void test_longer(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("longer.h5"), .override = "time.end=0.1", .flush_every = 900};
    must(&of);
    of.resume = 1;
    must(&of);
    assert_int_equal(of.found, 2);
    of.override = NULL;
    must(&of);
    assert_int_equal(of.found, 1);
    assert_false(exists("longer.h5.part"));
    assert_same(of.path);
    of.override = "contact.friction=0.5";
    refused(&of, RY_BAD_INPUT, "contact.friction: 0.57");
    of.override = "title=another";
    must(&of);
    assert_int_equal(of.found, 2);
}

static void test_fields(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("few.h5"),
               .override = "output.fields=[spin]",
               .flush_every = 900,
               .until = 2000};
    must(&of);
    of.resume = 1;
    of.until = 0;
    must(&of);
    assert_int_equal(of.found, 1);
    assert_false(exists("few.xdmf"));
    of = (plan){.path = in_folder("none.h5"), .override = "output.fields=[]", .flush_every = 900};
    (void)run(&of);
}

static void test_paths(void **unused)
{
    (void)unused;
    plan of = {.path = whole(), .flush_every = 1000, .until = 100};
    refused(&of, RY_BAD_FILE, "--force");
    of.path = folder;
    refused(&of, RY_BAD_FILE, "folder");
    of.path = in_folder("nowhere/x.h5");
    refused(&of, RY_BAD_FILE, "No such file");
    of.path = in_folder("whole.h5/x.h5");
    refused(&of, RY_BAD_FILE, "whole.h5");
    of.path = "/dev/full";
    refused(&of, RY_BAD_FILE, "regular file");
    of.path = "";
    refused(&of, RY_BAD_FILE, "empty");
    of.path = in_folder("no ending");
    of.until = 0;
    must(&of);
    assert_true(exists("no ending") && exists("no ending.xdmf"));
}

static void test_leftover(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("left.h5"), .flush_every = 1000, .until = 1500};
    must(&of);
    refused(&of, RY_BAD_FILE, "--resume");
    of.force = 1;
    of.until = 500;
    must(&of); /* this one leaves no checkpoint */
    of.force = 0;
    of.resume = 1;
    must(&of);
    assert_int_equal(of.found, 0);
}

static void test_foreign(void **unused)
{
    (void)unused;
    plan of = {.path = in_folder("foreign.h5"), .flush_every = 1000, .resume = 1};
    FILE *const file = fopen(in_folder("foreign.h5.part"), "w");
    fputs("this is a text, not a result", file);
    fclose(file);
    refused(&of, RY_BAD_FILE, "not an HDF5 file");
    if (have_h5py()) {
        assert_int_equal(python("foreign", in_folder("foreign.h5.part"), NULL), 0);
        refused(&of, RY_BAD_FILE, "has no /h5md");
    }
    assert_int_equal(truncate(in_folder("foreign.h5.part"), 0), 0);
    must(&of);
    assert_int_equal(of.found, 0);
    assert_same(of.path);
}

static void test_lock(void **unused)
{
    (void)unused;
    const char *const path = in_folder("locked.h5");
    ry_config config = config_of(NULL);
    ry_state state = first_state();
    ry_result *first = NULL;
    assert_int_equal(ry_result_create(&first, path, &config, &state, 0, NULL), RY_OK);
    plan of = {.path = path, .flush_every = 1000, .until = 100, .force = 1};
    refused(&of, RY_BAD_FILE, "in use by another run");
    of.resume = 1;
    refused(&of, RY_BAD_FILE, "in use by another run");
    if (have_h5py()) {
        assert_int_equal(python("opens", in_folder("locked.h5.part"), NULL), 0);
    }
    ry_result_close(first);
    of.resume = 0;
    must(&of);
    ry_state_free(&state);
    ry_config_free(&config);
}

static void write_nothing(void *data, const char *text)
{
    *(size_t *)data += strlen(text);
}

static void test_describe(void **unused)
{
    (void)unused;
    size_t length = 0;
    ry_error error = {0};
    assert_int_equal(ry_result_describe(whole(), write_nothing, &length, &error), RY_OK);
    assert_true(length > 1000);
    plan of = {.path = in_folder("part.h5"),
               .override = "output.fields=[flux]",
               .flush_every = 1000,
               .until = 1500};
    must(&of);
    assert_int_equal(ry_result_describe(in_folder("part.h5.part"), write_nothing, &length, &error),
                     RY_OK);
    assert_int_equal(ry_result_describe(in_folder("nowhere"), write_nothing, &length, &error),
                     RY_BAD_FILE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hash),     cmocka_unit_test(test_layout),
        cmocka_unit_test(test_resume),   cmocka_unit_test(test_fallback),
        cmocka_unit_test(test_longer),   cmocka_unit_test(test_fields),
        cmocka_unit_test(test_paths),    cmocka_unit_test(test_leftover),
        cmocka_unit_test(test_foreign),  cmocka_unit_test(test_lock),
        cmocka_unit_test(test_describe),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
