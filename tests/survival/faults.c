/* Loaded before the C library: kills the process at a chosen one of the calls that change files below a folder. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

enum { BEFORE, MIDDLE, AFTER };

static char folder[4096];
static long countdown = 0, calls = 0;
static int moment = BEFORE;

/* Kill at the call number `at` from now on, 1 the first; 0 never. */
void arm(const char *below, long at, int how) {
    strncpy(folder, below, sizeof folder - 1);
    countdown = at;
    moment = how;
    calls = 0;
}

long counted(void) { return calls; }

static int below_folder(const char *path) { return folder[0] && strncmp(path, folder, strlen(folder)) == 0; }

static int is_ours(int descriptor) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return below_folder(path);
}

static void die(void) {
    kill(getpid(), SIGKILL);
    pause();
}

/* Whether this call is the chosen one; dies at once if it is to die before it. */
static int chosen(void) {
    calls++;
    if (countdown == 0 || --countdown != 0) return 0;
    if (moment == BEFORE) die();
    return 1;
}

#define REAL(name, type) __typeof__(type) *real = (__typeof__(type) *)dlsym(RTLD_NEXT, name)

ssize_t write(int descriptor, const void *data, size_t size) {
    REAL("write", ssize_t(int, const void *, size_t));
    if (!is_ours(descriptor) || !chosen()) return real(descriptor, data, size);
    ssize_t done = real(descriptor, data, moment == MIDDLE ? size / 2 : size);
    die();
    return done;
}

static ssize_t placed(const char *name, int descriptor, const void *data, size_t size, off_t place) {
    REAL(name, ssize_t(int, const void *, size_t, off_t));
    if (!is_ours(descriptor) || !chosen()) return real(descriptor, data, size, place);
    ssize_t done = real(descriptor, data, moment == MIDDLE ? size / 2 : size, place);
    die();
    return done;
}

ssize_t pwrite(int descriptor, const void *data, size_t size, off_t place) {
    return placed("pwrite", descriptor, data, size, place);
}

ssize_t pwrite64(int descriptor, const void *data, size_t size, off_t place) {
    return placed("pwrite64", descriptor, data, size, place);
}

static int resized(const char *name, int descriptor, off_t size) {
    REAL(name, int(int, off_t));
    int ours = is_ours(descriptor) && chosen(), result = real(descriptor, size);
    if (ours) die();
    return result;
}

int ftruncate(int descriptor, off_t size) { return resized("ftruncate", descriptor, size); }
int ftruncate64(int descriptor, off_t size) { return resized("ftruncate64", descriptor, size); }

static int renamed(const char *name, const char *from, const char *to) {
    REAL(name, int(const char *, const char *));
    int ours = below_folder(to) && chosen(), result = real(from, to);
    if (ours) die();
    return result;
}

int rename(const char *from, const char *to) { return renamed("rename", from, to); }
int link(const char *from, const char *to) { return renamed("link", from, to); }

int unlink(const char *path) {
    REAL("unlink", int(const char *));
    int ours = below_folder(path) && chosen(), result = real(path);
    if (ours) die();
    return result;
}
