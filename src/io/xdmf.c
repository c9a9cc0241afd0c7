/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * OUT.xdmf: tells ParaView and VisIt where in OUT.h5 the frames lie. It names the file without its
 * folder, so that both can be moved together; "./" because their reader drops letters other than ASCII
 * from the beginning of a text. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/result_private.h"

typedef struct frames {
    const char *h5; /* name without folder */
    char *title;
    int64_t n, count;
    double *time;
    int positions, velocities, spins; /* which of them the file has */
} frames;

/* Text as XML wants it. */
static void put_escaped(FILE *stream, const char *text)
{
    for (; *text != '\0'; ++text) {
        switch (*text) {
        case '&': fputs("&amp;", stream); break;
        case '<': fputs("&lt;", stream); break;
        case '>': fputs("&gt;", stream); break;
        case '"': fputs("&quot;", stream); break;
        default: fputc((unsigned char)*text < ' ' ? ' ' : *text, stream);
        }
    }
}

static void put_file(FILE *stream, const frames *all, const char *path)
{
    fputs("./", stream);
    put_escaped(stream, all->h5);
    fprintf(stream, ":/particles/grains/%s</DataItem>\n", path);
}

/* Row `frame` of an array [frame][n][components]; components 1: of [frame][n]. */
static void put_row(FILE *stream, const frames *all, int64_t frame, const char *path,
                    int components)
{
    const long long n = all->n, count = all->count, at = frame;
    if (components == 1) {
        fprintf(stream, "          <DataItem ItemType=\"HyperSlab\" Dimensions=\"%lld\">\n", n);
        fprintf(
            stream,
            "            <DataItem Dimensions=\"3 2\" Format=\"XML\">%lld 0 1 1 1 %lld</DataItem>\n",
            at, n);
        fprintf(stream, "            <DataItem Dimensions=\"%lld %lld\"", count, n);
    } else {
        fprintf(stream, "          <DataItem ItemType=\"HyperSlab\" Dimensions=\"%lld 2\">\n", n);
        fprintf(
            stream,
            "            <DataItem Dimensions=\"3 3\" Format=\"XML\">%lld 0 0 1 1 1 1 %lld 2</DataItem>\n",
            at, n);
        fprintf(stream, "            <DataItem Dimensions=\"%lld %lld 2\"", count, n);
    }
    fprintf(stream, " NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">");
    put_file(stream, all, path);
    fprintf(stream, "          </DataItem>\n");
}

static void put_attribute(FILE *stream, const frames *all, int64_t frame, const char *name,
                          int components)
{
    char path[60];
    snprintf(path, sizeof path, "%s/value", name);
    fprintf(stream, "        <Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">\n", name,
            components == 1 ? "Scalar" : "Vector");
    put_row(stream, all, frame, path, components);
    fprintf(stream, "        </Attribute>\n");
}

static void put_fixed(FILE *stream, const frames *all, const char *name, const char *type)
{
    fprintf(stream, "        <Attribute Name=\"%s\" AttributeType=\"Scalar\" Center=\"Node\">\n",
            name);
    fprintf(stream, "          <DataItem Dimensions=\"%lld\" %s Format=\"HDF\">", (long long)all->n,
            type);
    put_file(stream, all, name);
    fprintf(stream, "        </Attribute>\n");
}

static void put_frame(FILE *stream, const frames *all, int64_t frame)
{
    fprintf(stream, "      <Grid Name=\"grains\" GridType=\"Uniform\">\n");
    fprintf(stream, "        <Time Value=\"%.17g\"/>\n", all->time[frame]);
    fprintf(
        stream,
        "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%lld\" NodesPerElement=\"1\"/>\n",
        (long long)all->n);
    fprintf(stream, "        <Geometry GeometryType=\"XY\">\n");
    put_row(stream, all, frame, "position/value", 2);
    fprintf(stream, "        </Geometry>\n");
    if (all->velocities) {
        put_attribute(stream, all, frame, "velocity", 2);
    }
    if (all->spins) {
        put_attribute(stream, all, frame, "spin", 1);
    }
    put_fixed(stream, all, "diameter", "NumberType=\"Float\" Precision=\"8\"");
    put_fixed(stream, all, "density", "NumberType=\"Float\" Precision=\"8\"");
    put_fixed(stream, all, "id", "NumberType=\"Int\" Precision=\"4\"");
    put_fixed(stream, all, "fixed", "NumberType=\"Int\" Precision=\"4\"");
    fprintf(stream, "      </Grid>\n");
}

static void put_all(FILE *stream, const frames *all)
{
    fprintf(stream,
            "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Xdmf Version=\"2.0\">\n  <Domain>\n");
    fprintf(stream, "    <Grid Name=\"");
    put_escaped(stream, all->title != NULL && all->title[0] != '\0' ? all->title : "ryusa");
    fprintf(stream, "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n");
    for (int64_t k = 0; k < all->count; ++k) {
        put_frame(stream, all, k);
    }
    fprintf(stream, "    </Grid>\n  </Domain>\n</Xdmf>\n");
}

static ry_status write_to(const char *path, const frames *all, ry_error *error)
{
    FILE *const stream = fopen(path, "w");
    if (stream == NULL) {
        return ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(errno));
    }
    errno = 0;
    put_all(stream, all);
    const int failed = ferror(stream);
    const int failure = fclose(stream) != 0 || failed ? (errno != 0 ? errno : EIO) : 0;
    if (failure != 0) {
        unlink(path);
        return ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(failure));
    }
    return RY_OK;
}

static int read_frames(hid_t file, frames *all)
{
    ry_h5_shape times, ids;
    ry_h5_get_text(file, "parameters", "title", &all->title);
    all->positions = ry_h5_exists(file, "particles/grains/position");
    all->velocities = ry_h5_exists(file, "particles/grains/velocity");
    all->spins = ry_h5_exists(file, "particles/grains/spin");
    if (!all->positions) {
        return 0;
    }
    if (ry_h5_get_shape(file, "particles/grains/position/time", &times) != 0 || times.rank != 1 ||
        ry_h5_get_shape(file, "particles/grains/id", &ids) != 0 || ids.rank != 1) {
        return -1;
    }
    all->n = (int64_t)ids.size[0];
    all->count = (int64_t)times.size[0];
    all->time = ry_array((size_t)all->count, sizeof(double));
    return all->time != NULL &&
                   (all->count == 0 || ry_h5_read(file, "particles/grains/position/time",
                                                  H5T_NATIVE_DOUBLE, times.size[0], all->time) == 0)
               ? 0
               : -1;
}

static ry_status look_into(frames *all, const char *h5_path, ry_error *error)
{
    ry_h5 file;
    RY_TRY(ry_h5_open(&file, h5_path, -1, RY_H5_READ, error));
    const int failed = read_frames(file.id, all);
    ry_h5_close(&file, 1, "", NULL);
    return failed ? ry_fail(error, RY_BAD_FILE, "%s: its frames can't be read", h5_path) : RY_OK;
}

/* OUT.xdmf for OUT.h5, NAME.xdmf for any other NAME. */
static char *xdmf_path(const char *h5_path)
{
    return ry_text_print("%.*s.xdmf", ry_text_stem(h5_path), h5_path);
}

static ry_status write_and_rename(const char *path, const frames *all, ry_error *error)
{
    char *const part = ry_text_print("%s.part", path);
    if (part == NULL) {
        return ry_no_memory(error, strlen(path));
    }
    ry_status status = write_to(part, all, error);
    if (status == RY_OK && rename(part, path) != 0) {
        status = ry_fail(error, RY_BAD_FILE, "%s: %s", path, strerror(errno));
    }
    free(part);
    return status;
}

ry_status ry_xdmf_write(const char *h5_path, int anew, ry_error *error)
{
    char *const path = xdmf_path(h5_path);
    if (path == NULL) {
        return ry_no_memory(error, strlen(h5_path));
    }
    const char *const slash = strrchr(h5_path, '/');
    frames all = {.h5 = slash != NULL ? slash + 1 : h5_path};
    ry_status status = RY_OK;
    if (anew || access(path, F_OK) != 0) {
        status = look_into(&all, h5_path, error);
        if (status == RY_OK && all.positions) {
            status = write_and_rename(path, &all, error);
        } else if (status == RY_OK) {
            unlink(path); /* an older one would show frames that are gone */
        }
    }
    free(all.time);
    free(all.title);
    free(path);
    return status;
}
