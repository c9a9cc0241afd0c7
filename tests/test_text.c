/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Small files and their names. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/text.h"

static void check(const char *path, const char *expected)
{
    char *text;
    ry_error error;
    assert_int_equal(ry_text_read(path, 1000, "a text", &text, &error), RY_OK);
    assert_string_equal(text, expected);
    free(text);
}

/* The temporary file of another process of our number, on another machine that shares the folder or killed: it stays,
 * and what is written is ours. */
static void test_half_written(void **state)
{
    (void)state;
    char folder[] = "/tmp/ryusa-text-XXXXXX", part[200], path[100];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/x.txt", folder);
    snprintf(part, sizeof part, "%s.%ld.part", path, (long)getpid());
    FILE *const other = fopen(part, "w");
    assert_non_null(other);
    fputs("theirs", other);
    fclose(other);
    ry_error error;
    assert_int_equal(ry_text_write(path, "ours", &error), RY_OK);
    check(path, "ours");
    check(part, "theirs");
    assert_int_equal(unlink(part), 0);
    assert_int_equal(ry_text_write(path, "later", &error), RY_OK);
    check(path, "later");
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0); /* nothing else is left */
    assert_int_equal(ry_text_write(path, "nowhere", &error), RY_BAD_FILE);
}

static void test_stem(void **state)
{
    (void)state;
    assert_int_equal(ry_text_stem("a.h5"), 1);
    assert_int_equal(ry_text_stem("a.h5.part"), 9);
    assert_int_equal(ry_text_stem(".h5"), 3); /* a name, not an ending */
    assert_int_equal(ry_text_stem(""), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_half_written), cmocka_unit_test(test_stem)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
