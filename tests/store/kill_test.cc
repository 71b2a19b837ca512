// SIGKILL in the middle of writes: every entry that was answered is there afterwards.

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "server/base/random.h"
#include "tests/store/fixture.h"
#include "tests/support/paths.h"
#include "tests/support/temporary_folder.h"

namespace kerf::test {
namespace {

struct Life {
  std::int64_t recovered = -1;
  std::vector<std::int64_t> answered;
};

// Runs the program that appends, kills it after it has printed a number of answers, and reads what it printed.
Life run_and_kill(const std::string& folder, std::size_t num_answers) {
  Life life;
  const std::string program = test::program_path("store_appender");
  int ends[2] = {};
  if (::pipe2(ends, O_CLOEXEC) != 0) return life;
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::execl(program.c_str(), program.c_str(), folder.c_str(), nullptr);
    ::_exit(127);
  }
  ::close(ends[1]);
  std::FILE* const lines = ::fdopen(ends[0], "r");
  long long number = 0;
  if (std::fscanf(lines, "recovered %lld", &number) == 1) life.recovered = number;
  while (life.answered.size() < num_answers && std::fscanf(lines, "%lld", &number) == 1)
    life.answered.push_back(number);
  ::kill(child, SIGKILL);
  while (std::fscanf(lines, "%lld", &number) == 1) life.answered.push_back(number);
  std::fclose(lines);
  ::waitpid(child, nullptr, 0);
  return life;
}

TEST(Kill, NothingAnsweredIsLost) {
  const TemporaryFolder folder;
  const std::string path = folder / "data";
  SeededRandom random(1);
  std::int64_t answered = 0;
  for (int kill = 0; kill < 20; ++kill) {
    const Life life = run_and_kill(path, 1 + random.below(150));
    ASSERT_GE(life.recovered, answered) << "kill " << kill;
    std::int64_t next = life.recovered;
    for (const std::int64_t one : life.answered) ASSERT_EQ(one, ++next) << "kill " << kill;
    ASSERT_FALSE(life.answered.empty()) << "kill " << kill;
    answered = life.answered.back();
    const auto report = store::check_store(path);
    ASSERT_TRUE(report.ok()) << report.error().message;
    ASSERT_THAT(report->faults, testing::IsEmpty()) << "kill " << kill;
    ASSERT_GE(report->info.requests, answered) << "kill " << kill;
  }
  EXPECT_GT(answered, 500);
}

}  // namespace
}  // namespace kerf::test
