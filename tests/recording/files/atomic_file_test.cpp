// SPDX-License-Identifier: BSD-3-Clause
// Files are written whole or not at all, wherever they go.
#include "recording/files/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <thread>

#include "tests/recording/test_files.h"

namespace magimu {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(WriteAtomically, writes_a_new_file_and_replaces_an_old_one_leaving_nothing_else) {
  const test::TempFolder folder;
  const std::string path = folder.path("a.json");
  write_atomically(path, "first");
  EXPECT_EQ(test::content_of(path), "first");
  write_atomically(path, std::string(3'000'000, 'x'));
  EXPECT_EQ(test::content_of(path), std::string(3'000'000, 'x'));
  write_atomically(path, "");
  EXPECT_EQ(test::content_of(path), "");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WriteAtomically, writes_into_the_current_folder_and_under_the_longest_of_names) {
  const test::TempFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.path(""));
  const std::string name(255, 'n');
  write_atomically(name, "x");
  fs::current_path(before);
  EXPECT_EQ(test::content_of(folder.path(name)), "x");
}

TEST(WriteAtomically, a_new_file_has_the_usual_permissions_and_an_old_one_keeps_its_own) {
  const test::TempFolder folder;
  const std::string path = folder.write("a", "old");
  const std::string fresh = folder.path("b");
  write_atomically(fresh, "new");
  EXPECT_EQ(fs::status(fresh).permissions(), fs::status(path).permissions());
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  write_atomically(path, "new");
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST(WriteAtomically, a_symbolic_link_stays_and_its_target_is_replaced) {
  const test::TempFolder folder;
  fs::create_directory(folder.path("sub"));
  folder.write("sub/target", "old");
  fs::create_symlink("sub/target", folder.path("link"));
  fs::create_symlink("sub/not_yet", folder.path("dangling"));
  write_atomically(folder.path("link"), "new");
  write_atomically(folder.path("dangling"), "made");
  EXPECT_TRUE(fs::is_symlink(folder.path("link")));
  EXPECT_EQ(test::content_of(folder.path("sub/target")), "new");
  EXPECT_EQ(test::content_of(folder.path("sub/not_yet")), "made");
}

TEST(WriteAtomically, links_that_lead_in_a_circle_are_an_error) {
  const test::TempFolder folder;
  fs::create_symlink("b", folder.path("a"));
  fs::create_symlink("a", folder.path("b"));
  const InputError error = test::error_of([&] { write_atomically(folder.path("a"), "x"); });
  EXPECT_THAT(error.remedy, HasSubstr("circle"));
}

TEST(WriteAtomically, a_pipe_is_written_directly) {
  const test::TempFolder folder;
  const std::string path = folder.path("pipe");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = test::content_of(path); });
  write_atomically(path, "through the pipe");
  reader.join();
  EXPECT_EQ(got, "through the pipe");
  EXPECT_TRUE(fs::is_fifo(path));
}

TEST(WriteAtomically, standard_output_goes_on_where_it_was_even_if_it_is_a_file) {
  const test::TempFolder folder;
  const std::string path = folder.write("out", "before ");
  std::fflush(stdout);
  const int saved = ::dup(STDOUT_FILENO);
  const int file = ::open(path.c_str(), O_WRONLY | O_APPEND);
  ::dup2(file, STDOUT_FILENO);
  write_atomically("/dev/stdout", "content");
  ::dup2(saved, STDOUT_FILENO);
  ::close(saved);
  ::close(file);
  EXPECT_EQ(test::content_of(path), "before content");
}

TEST(WriteAtomically, a_missing_folder_or_a_folder_itself_is_an_error_with_a_remedy) {
  const test::TempFolder folder;
  InputError error = test::error_of([&] { write_atomically(folder.path("no/a.json"), "x"); });
  EXPECT_EQ(error.file, folder.path("no/a.json"));
  EXPECT_THAT(error.problem, HasSubstr("cannot be written: No such file or directory"));
  EXPECT_THAT(error.remedy, HasSubstr("create its folder first"));
  error = test::error_of([&] { write_atomically(folder.path(""), "x"); });
  EXPECT_THAT(error.remedy, HasSubstr("add a file name"));
  error = test::error_of([&] { write_atomically("", "x"); });
  EXPECT_THAT(error.problem, HasSubstr("cannot be written"));
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(WriteAtomically, a_full_device_is_an_error) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const InputError error = test::error_of([] { write_atomically("/dev/full", "x"); });
  EXPECT_THAT(error.remedy, HasSubstr("free some space"));
}

TEST(WriteAtomically, after_a_failure_half_way_the_old_file_is_as_it_was_and_nothing_is_left) {
  const test::TempFolder folder;
  const std::string path = folder.write("a", "old");
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1000, before.rlim_max};
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &small);
  const InputError error =
      test::error_of([&] { write_atomically(path, std::string(100'000, 'x')); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, previous);
  EXPECT_THAT(error.problem, HasSubstr("File too large"));
  EXPECT_EQ(test::content_of(path), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WriteAtomically, what_a_killed_run_left_goes_and_what_another_is_writing_stays) {
  const test::TempFolder folder;
  folder.write(".magimu-123-0", "half a calib");
  folder.write(".magimu-" + std::to_string(::getpid()) + "-99", "of a process with our number");
  folder.write(".magimu-notes", "of somebody else");
  const std::string busy = folder.write(".magimu-124-7", "half");
  const int writer = ::open(busy.c_str(), O_WRONLY);
  ASSERT_EQ(::flock(writer, LOCK_EX), 0);
  const std::string path = folder.path("a.json");
  write_atomically(path, "x");
  EXPECT_EQ(test::content_of(path), "x");
  EXPECT_TRUE(fs::exists(busy));
  EXPECT_TRUE(fs::exists(folder.path(".magimu-notes")));
  EXPECT_EQ(folder.entries(), 3u);
  ::close(writer);
}

TEST(WriteAtomically, a_process_that_is_killed_leaves_what_the_next_one_removes) {
  const test::TempFolder folder;
  const std::string path = folder.path("a.json");
  const std::string content(50'000'000, 'x');
  const auto temporary = [&] { return folder.entries() > 0; };
  const pid_t child = ::fork();
  if (child == 0) {
    while (true) write_atomically(path, content);
  }
  while (!temporary()) std::this_thread::yield();
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const pid_t next = ::fork();
  if (next == 0) {
    write_atomically(path, "x");
    ::_exit(0);
  }
  int status = -1;
  ::waitpid(next, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(test::content_of(path), "x");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WriteAtomically, a_write_protected_file_is_left_alone) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everything";
  const test::TempFolder folder;
  const std::string path = folder.write("a", "old");
  fs::permissions(path, fs::perms::owner_read);
  const InputError error = test::error_of([&] { write_atomically(path, "new"); });
  EXPECT_THAT(error.remedy, HasSubstr("may write"));
  EXPECT_EQ(test::content_of(path), "old");
}

}  // namespace
}  // namespace magimu
