// The file of segcal replay --state through kills, full disks, closed
// folders and two runs at once: the old one or the new one, whole.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <unity.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <thread>
#include <vector>

#include "../replay/temporary_folder.h"
#include "recording.h"
#include "state/state_file.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using host::StateFile;

constexpr std::size_t kBytes = 1 << 20;

void put(char content, StateFile* state) {
  state->profile = std::string("profile ") + content;
  state->logs.push_back({std::string(1, content), "", ""});
  state->flash.bytes.assign(kBytes, content);
}

fs::path made(const fs::path& folder) {
  const fs::path file = folder / "a.state";
  StateFile state(file);
  TEST_ASSERT_TRUE(state.is_new());
  put('a', &state);
  state.write();
  return file;
}

/// 'a' or 'b', by what the file holds; all of it must be of the same.
char content_of(const fs::path& file) {
  const StateFile state(file);
  TEST_ASSERT_EQUAL_UINT(kBytes, state.flash.bytes.size());
  const char content = state.flash.bytes.front();
  TEST_ASSERT_EQUAL_UINT64(std::string::npos, state.flash.bytes.find_first_not_of(content));
  TEST_ASSERT_EQUAL_STRING((std::string("profile ") + content).c_str(), state.profile.c_str());
  TEST_ASSERT_EQUAL_UINT(content == 'a' ? 1 : 2, state.logs.size());
  return content;
}

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/// What `work` returns, done by a process of its own, which is killed
/// after `us` microseconds (negative: never). -1: it was killed.
int in_child(long us, const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  if (us >= 0) {
    std::this_thread::sleep_for(std::chrono::microseconds(us));
    ::kill(child, SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int replace(const fs::path& file) {
  try {
    StateFile state(file);
    put('b', &state);
    state.write();
    return 0;
  } catch (const host::InputError&) {
    return 2;
  }
}

/// The process is killed at the given byte of the file that it writes: SIGXFSZ, unhandled.
int replace_until(const fs::path& file, std::size_t bytes) {
  return in_child(-1, [&] {
    const rlimit no_core = {0, 0}, limit = {bytes, bytes};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::setrlimit(RLIMIT_FSIZE, &limit);
    return replace(file);
  });
}

void test_a_kill_at_any_byte_leaves_the_old() {
  const test::TemporaryFolder folder("segcal_state_byte");
  const fs::path file = made(folder.path());
  const std::size_t size = fs::file_size(file);
  std::vector<std::size_t> places = {0, 1, 79, 80, 81, 200, size - 1};
  for (std::size_t i = 1; i < 16; ++i) places.push_back(i * size / 16);
  for (const std::size_t bytes : places) {
    TEST_ASSERT_EQUAL_INT(-1, replace_until(file, bytes));
    TEST_ASSERT_EQUAL_CHAR('a', content_of(file));
    TEST_ASSERT_EQUAL_UINT(1, files_in(folder.path()));  // reading it removed what the killed one left
  }
  TEST_ASSERT_EQUAL_INT(0, replace_until(file, 2 * size));
  TEST_ASSERT_EQUAL_CHAR('b', content_of(file));
}

/// Kills at times spread over twice what replacing takes: the rename and what is around it too.
void test_a_kill_at_any_time_leaves_the_old_or_the_new() {
  const test::TemporaryFolder folder("segcal_state_kill");
  const fs::path file = made(folder.path());
  const auto start = std::chrono::steady_clock::now();
  TEST_ASSERT_EQUAL_INT(0, in_child(-1, [&file] { return replace(file); }));
  const long us =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - start).count();
  constexpr int kKills = 40;
  for (int i = 0; i < kKills; ++i) {
    fs::remove(file);
    made(folder.path());
    in_child(2 * us * i / kKills, [&file] { return replace(file); });
    content_of(file);
    TEST_ASSERT_EQUAL_UINT(1, files_in(folder.path()));
  }
}

/// A kill while the first state is made: there is none then, and the next run makes it.
void test_a_kill_before_the_first_state() {
  const test::TemporaryFolder folder("segcal_state_first");
  const fs::path file = folder.path() / "deep/er/a.state";
  in_child(-1, [&file]() -> int {
    StateFile state(file);
    ::kill(::getpid(), SIGKILL);
    return 0;
  });
  TEST_ASSERT_TRUE(StateFile(file).is_new());
}

void test_a_full_disk_leaves_the_old() {
  const test::TemporaryFolder folder("segcal_state_full");
  const fs::path file = made(folder.path());
  const int code = in_child(-1, [&file] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {kBytes / 2, kBytes / 2};  // a write beyond that fails, as on a full disk
    ::setrlimit(RLIMIT_FSIZE, &limit);
    return replace(file);
  });
  TEST_ASSERT_EQUAL_INT(2, code);
  TEST_ASSERT_EQUAL_UINT(1, files_in(folder.path()));
  TEST_ASSERT_EQUAL_CHAR('a', content_of(file));
}

void test_a_closed_folder_is_found_at_once() {
  const test::TemporaryFolder folder("segcal_state_closed");
  const fs::path file = made(folder.path());
  fs::permissions(file, fs::perms(0666));
  fs::permissions(folder.path(), fs::perms(0555));
  const int code = in_child(-1, [&file] {
    if (::geteuid() == 0 && ::setuid(65534) != 0) return 1;  // the administrator may write anywhere
    try {
      StateFile state(file);
      return 0;
    } catch (const host::InputError&) {
      return 2;
    }
  });
  fs::permissions(folder.path(), fs::perms(0755));
  TEST_ASSERT_EQUAL_INT(2, code);
  TEST_ASSERT_EQUAL_CHAR('a', content_of(file));
}

void test_one_run_at_a_time() {
  const test::TemporaryFolder folder("segcal_state_two");
  const fs::path file = made(folder.path()), link = folder.path() / "link.state";
  fs::create_symlink(file, link);
  {
    StateFile first(file);
    for (const fs::path& name : {file, link}) TEST_ASSERT_EQUAL_INT(2, in_child(-1, [&name] { return replace(name); }));
    put('b', &first);
    first.write();
  }
  TEST_ASSERT_EQUAL_CHAR('b', content_of(link));
  TEST_ASSERT_TRUE(fs::is_symlink(link));
}

/// Who only looked, or failed, leaves no empty file behind.
void test_nothing_is_left_of_a_new_one() {
  const test::TemporaryFolder folder("segcal_state_none");
  { const StateFile state(folder.path() / "a.state"); }
  TEST_ASSERT_EQUAL_UINT(0, files_in(folder.path()));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_kill_at_any_byte_leaves_the_old);
  RUN_TEST(test_a_kill_at_any_time_leaves_the_old_or_the_new);
  RUN_TEST(test_a_kill_before_the_first_state);
  RUN_TEST(test_a_full_disk_leaves_the_old);
  RUN_TEST(test_a_closed_folder_is_found_at_once);
  RUN_TEST(test_one_run_at_a_time);
  RUN_TEST(test_nothing_is_left_of_a_new_one);
  return UNITY_END();
}
