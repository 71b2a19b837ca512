#pragma once

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/paths.h"
#include "tests/support/temporary_folder.h"
#include "tests/ws/raw_client.h"

// Tests of the kerfd that ships, as a process.
namespace kerf::rpc_test {

inline constexpr int kPatienceMs = 30'000;

// A kerfd of its own, with pipes on its outputs. Killed at the end if it still runs.
class Kerfd {
 public:
  // `limit`: arguments of the shell's ulimit, such as "-n 64"; empty: the limits of this process.
  explicit Kerfd(std::vector<std::string> arguments, const std::string& limit = "") {
    std::array<int, 2> out{};
    std::array<int, 2> err{};
    EXPECT_EQ(::pipe2(out.data(), O_CLOEXEC), 0);
    EXPECT_EQ(::pipe2(err.data(), O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
    if (std::find(arguments.begin(), arguments.end(), "--data") == arguments.end()) {
      arguments.insert(arguments.begin(), {"--data", "none"});
    }
    std::string program = test::program_path("kerfd");
    arguments.insert(arguments.begin(), program);
    if (!limit.empty()) {
      program = "/bin/sh";
      const std::string limited = "ulimit " + limit + R"(; exec "$0" "$@")";
      arguments.insert(arguments.begin(), {program, "-c", limited});
    }
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    EXPECT_EQ(::posix_spawn(&pid_, program.c_str(), &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    ::close(out[1]);
    ::close(err[1]);
    out_ = out[0];
    err_ = err[0];
  }
  ~Kerfd() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    ::close(out_);
    ::close(err_);
  }
  Kerfd(const Kerfd&) = delete;
  Kerfd& operator=(const Kerfd&) = delete;

  // One line of standard output, with its newline; what there is when it closes or nothing more comes.
  std::string read_line() const { return read(out_, true); }
  std::string rest_of_output() const { return read(out_, false); }
  std::string errors() const { return read(err_, false); }
  void signal(int number) const { ::kill(pid_, number); }
  // The exit status; -signal if one ended it.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  static std::string read(int file, bool line) {
    std::string text;
    pollfd ready{file, POLLIN, 0};
    while (::poll(&ready, 1, kPatienceMs) == 1) {
      char byte = 0;
      if (::read(file, &byte, 1) != 1) break;
      text += byte;
      if (line && byte == '\n') break;
    }
    return text;
  }

  pid_t pid_ = 0;
  int out_ = -1;
  int err_ = -1;
};

class KerfdTest : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& content) const {
    return folder_.write(name, content).string();
  }
  static std::vector<std::string> free_ports(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--no-render"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  // Runs kerfd, which must refuse with exit status 2 and one line, and returns the line.
  static std::string refusal(std::vector<std::string> arguments) {
    Kerfd kerfd(std::move(arguments));
    EXPECT_EQ(kerfd.rest_of_output(), "");
    const std::string line = kerfd.errors();
    EXPECT_EQ(kerfd.wait(), 2);
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    EXPECT_EQ(line.rfind("kerfd: ", 0), 0U) << line;
    return line;
  }
  // A connection for whose request a stop waits for some seconds. Takes the line that says that kerfd is ready.
  static std::unique_ptr<ws_test::RawClient> unfinished_request(const Kerfd& kerfd) {
    const std::string line = kerfd.read_line();
    auto client = std::make_unique<ws_test::RawClient>(std::stoi(line.substr(line.rfind(':') + 1)));
    client->send("POST /kerf.v1.SheetService/ListSheets HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n{");
    return client;
  }
  // Reads the ports of gRPC and HTTP from the line that says that kerfd is ready.
  static std::pair<int, int> ports(const Kerfd& kerfd) {
    const std::string line = kerfd.read_line();
    std::smatch match;
    const std::regex addresses(R"(127\.0\.0\.1:([0-9]+).*127\.0\.0\.1:([0-9]+))");
    if (!std::regex_search(line, match, addresses)) ADD_FAILURE() << line;
    return match.empty() ? std::pair(0, 0) : std::pair(std::stoi(match[1]), std::stoi(match[2]));
  }
  test::TemporaryFolder folder_;
};

inline constexpr const char* kScene = R"({"grid": {"columns": 6, "rows": 6, "width_m": 1, "height_m": 1}})";

}  // namespace kerf::rpc_test
