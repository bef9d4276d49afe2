// Runs a function in a child process that is killed (SIGKILL) at its n-th change of the file system. The calls of libc
// through which libstdc++ changes files are defined here anew, and count; one test program includes this once.
#pragma once

#include <dlfcn.h>
#include <signal.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <functional>

namespace test {

inline int changes_left = -1;  ///< below 0: nobody counts

inline void count_change() {
  if (changes_left > 0 && --changes_left == 0) ::kill(::getpid(), SIGKILL);
}

template <class Function>
Function* next_of(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

/// Killed before the n-th change (n from 1; 0: not at all); false: the function came to its end.
inline bool killed_at(int n, const std::function<void()>& function) {
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child == 0) {
    std::freopen("/dev/null", "w", stdout);
    std::freopen("/dev/null", "w", stderr);
    changes_left = n;
    try {
      function();
    } catch (...) {
      ::_exit(3);
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) return true;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return false;
  std::fprintf(stderr, "killed_at(%d): the child ended with status %d\n", n, status);
  std::abort();
}

}  // namespace test

extern "C" {

int rename(const char* from, const char* to) noexcept {
  test::count_change();
  return test::next_of<int(const char*, const char*)>("rename")(from, to);
}

int remove(const char* path) noexcept {
  test::count_change();
  return test::next_of<int(const char*)>("remove")(path);
}

ssize_t write(int fd, const void* bytes, size_t n) {
  if (fd > 2) test::count_change();
  return test::next_of<ssize_t(int, const void*, size_t)>("write")(fd, bytes, n);
}

struct iovec;
ssize_t writev(int fd, const struct iovec* pieces, int n) {
  if (fd > 2) test::count_change();
  return test::next_of<ssize_t(int, const struct iovec*, int)>("writev")(fd, pieces, n);
}

FILE* fopen(const char* path, const char* mode) {
  if (mode[0] == 'w') test::count_change();
  return test::next_of<FILE*(const char*, const char*)>("fopen")(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  if (mode[0] == 'w') test::count_change();
  return test::next_of<FILE*(const char*, const char*)>("fopen64")(path, mode);
}
}
