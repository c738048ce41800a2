// SPDX-License-Identifier: MIT
// A library to preload. It makes one call of the program fail as a full disk, a limit or a power cut would.
//   NLO_FAULT=alloc:N         the N-th allocation fails; alloc:N+ also all later ones
//   NLO_FAULT=call:N:ERRNO    the N-th call that changes a file system fails with that error number
//   NLO_FAULT=kill:N          the program is killed before the N-th such call
//   NLO_FAULT=exchange        renameat2() behaves as on a file system that cannot exchange names
//   NLO_FAULT_COUNT=FILE      a run that ends normally writes "allocations calls" there
// Calls that change a file system: open for writing, write and fsync (except on stdin, stdout and stderr), rename,
// mkdir, unlink, chmod. A call that fails is named on stderr: "fault: unlink". Counting starts with main() and covers
// only this program; programs that it starts (gnuplot) run unchanged. The library is written in C and uses the
// allocator's own names, because a library that is loaded first must not call anything that allocates before malloc is
// ready.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static atomic_long allocations, calls;
static atomic_int armed;
static long failing_allocation = -1, failing_call = -1;
static int and_all_after, kills, reason, no_exchange;
static const char* count_file;
static char preloaded[4096];

static void read_fault(void) {
  const char* fault = getenv("NLO_FAULT");
  count_file = getenv("NLO_FAULT_COUNT");
  const char* preload = getenv("LD_PRELOAD");
  if (preload != NULL) snprintf(preloaded, sizeof preloaded, "%s", preload);
  unsetenv("LD_PRELOAD");
  if (fault == NULL) return;
  char* rest = NULL;
  if (strncmp(fault, "alloc:", 6) == 0) {
    failing_allocation = strtol(fault + 6, &rest, 10);
    and_all_after = *rest == '+';
  } else if (strncmp(fault, "call:", 5) == 0) {
    failing_call = strtol(fault + 5, &rest, 10);
    reason = *rest == ':' ? atoi(rest + 1) : EIO;
  } else if (strncmp(fault, "kill:", 5) == 0) {
    failing_call = strtol(fault + 5, &rest, 10);
    kills = 1;
  } else if (strcmp(fault, "exchange") == 0) {
    no_exchange = 1;
  }
}

static void write_counts(void) {
  armed = 0;
  FILE* file = count_file == NULL ? NULL : fopen(count_file, "w");
  if (file == NULL) return;
  fprintf(file, "%ld %ld\n", (long)allocations, (long)calls);
  fclose(file);
}

/// A command that becomes another program (nlo certify) passes the faults on; a compiler that it starts does not get
/// them.
int execv(const char* path, char* const arguments[]) {
  armed = 0;
  setenv("LD_PRELOAD", preloaded, 1);
  execve(path, arguments, environ);
  unsetenv("LD_PRELOAD");
  return -1;
}

static int (*program)(int, char**, char**);

static int run(int argc, char** argv, char** environment) {
  read_fault();
  atexit(write_counts);
  armed = 1;
  return program(argc, argv, environment);
}

/// Static initialisers run before main() and cannot report an error, so counting starts with main().
int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void* stack_end) {
  int (*real)(int (*)(int, char**, char**), int, char**, void (*)(void), void (*)(void), void (*)(void), void*) =
      dlsym(RTLD_NEXT, "__libc_start_main");
  program = main;
  return real(run, argc, argv, init, fini, rtld_fini, stack_end);
}

static int allocation_fails(void) {
  if (!armed) return 0;
  const long number = ++allocations;
  if (number != failing_allocation && !(and_all_after && failing_allocation > 0 && number > failing_allocation))
    return 0;
  errno = ENOMEM;
  return 1;
}

/// `call`: the name of the call for stderr.
static int call_fails(const char* call) {
  if (!armed || ++calls != failing_call) return 0;
  if (kills) kill(getpid(), SIGKILL);
  armed = 0;
  dprintf(2, "fault: %s\n", call);
  armed = 1;
  errno = reason;
  return 1;
}

void* malloc(size_t size) {
  return allocation_fails() ? NULL : __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  return allocation_fails() ? NULL : __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  return allocation_fails() ? NULL : __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  return allocation_fails() ? NULL : __libc_memalign(alignment, size);
}
int posix_memalign(void** result, size_t alignment, size_t size) {
  void* made = allocation_fails() ? NULL : __libc_memalign(alignment, size);
  if (made == NULL) return ENOMEM;
  *result = made;
  return 0;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static mode_t mode_of(int flags, va_list arguments) {
  return flags & (O_CREAT | __O_TMPFILE) ? va_arg(arguments, mode_t) : 0;
}

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  if ((flags & O_ACCMODE) != O_RDONLY && call_fails("open")) return -1;
  return REAL(open)(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  if ((flags & O_ACCMODE) != O_RDONLY && call_fails("open64")) return -1;
  return REAL(open64)(path, flags, mode);
}
int mkostemp(char* name, int flags) {
  return call_fails("mkostemp") ? -1 : REAL(mkostemp)(name, flags);
}
int mkostemp64(char* name, int flags) {
  return call_fails("mkostemp64") ? -1 : REAL(mkostemp64)(name, flags);
}
char* mkdtemp(char* name) {
  return call_fails("mkdtemp") ? NULL : REAL(mkdtemp)(name);
}
ssize_t write(int fd, const void* bytes, size_t size) {
  return fd > 2 && call_fails("write") ? -1 : REAL(write)(fd, bytes, size);
}
ssize_t writev(int fd, const struct iovec* parts, int count) {
  return fd > 2 && call_fails("writev") ? -1 : REAL(writev)(fd, parts, count);
}
int fsync(int fd) {
  return call_fails("fsync") ? -1 : REAL(fsync)(fd);
}
int fchmod(int fd, mode_t mode) {
  return call_fails("fchmod") ? -1 : REAL(fchmod)(fd, mode);
}
int fchmodat(int folder, const char* path, mode_t mode, int flags) {
  return call_fails("fchmodat") ? -1 : REAL(fchmodat)(folder, path, mode, flags);
}
int mkdir(const char* path, mode_t mode) {
  return call_fails("mkdir") ? -1 : REAL(mkdir)(path, mode);
}
int rename(const char* from, const char* to) {
  return call_fails("rename") ? -1 : REAL(rename)(from, to);
}
int renameat2(int a, const char* from, int b, const char* to, unsigned flags) {
  if (no_exchange && flags != 0) {
    errno = EINVAL;
    return -1;
  }
  return call_fails("renameat2") ? -1 : REAL(renameat2)(a, from, b, to, flags);
}
int unlink(const char* path) {
  return call_fails("unlink") ? -1 : REAL(unlink)(path);
}
int unlinkat(int folder, const char* path, int flags) {
  return call_fails("unlinkat") ? -1 : REAL(unlinkat)(folder, path, flags);
}
int rmdir(const char* path) {
  return call_fails("rmdir") ? -1 : REAL(rmdir)(path);
}
int remove(const char* path) {
  return call_fails("remove") ? -1 : REAL(remove)(path);
}
