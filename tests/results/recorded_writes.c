/* Loaded before a program, this records each write to the file that RECORDED names, or that is to become it and has .part behind
   its name, and each change of its length, in the file that RECORD names: two numbers (offset and bytes of a write, or new length
   and -1), then the bytes. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static int is_recorded(int file)
{
    const char *name = getenv("RECORDED");
    char part[4096];
    struct stat one, other;
    if (!name || fstat(file, &one)) return 0;
    snprintf(part, sizeof part, "%s.part", name);
    if (stat(part, &other) && stat(name, &other)) return 0;
    return one.st_ino == other.st_ino && one.st_dev == other.st_dev;
}

static void record(int64_t first, int64_t second, const void *bytes, int64_t n)
{
    static int log = -1;
    int64_t head[2] = {first, second};
    if (log < 0) log = open(getenv("RECORD"), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (write(log, head, sizeof head) < 0 || (n > 0 && write(log, bytes, n) < n)) abort();
}

ssize_t pwrite(int file, const void *bytes, size_t n, off_t offset)
{
    static ssize_t (*next)(int, const void *, size_t, off_t);
    if (!next) next = dlsym(RTLD_NEXT, "pwrite");
    if (is_recorded(file)) record(offset, n, bytes, n);
    return next(file, bytes, n, offset);
}

int ftruncate(int file, off_t length)
{
    static int (*next)(int, off_t);
    if (!next) next = dlsym(RTLD_NEXT, "ftruncate");
    if (is_recorded(file)) record(length, -1, NULL, 0);
    return next(file, length);
}
