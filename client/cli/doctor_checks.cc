#include "client/cli/doctor_checks.h"

#include <fcntl.h>
#include <netdb.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <sstream>
#include <system_error>

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX declares it nowhere.

namespace kerf::cli {
namespace {

constexpr std::int64_t kGigabyte = 1'000'000'000;
constexpr std::int64_t kDay_s = 86'400;
constexpr std::int64_t kSoon_s = 14 * kDay_s;  // kerfd warns as early.
constexpr std::int64_t kFewFiles = 1024;
constexpr std::int64_t kUsualFiles = 4096;

std::string error_text(int number) {
  return std::generic_category().message(number);
}

std::string gigabytes(double bytes) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.1f GB", bytes / static_cast<double>(kGigabyte));
  return text.data();
}

std::string date_of(std::int64_t time_s) {
  const std::time_t time = time_s;
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return text.data();
}

// Returns what a program prints on its standard output, nothing if it cannot be started or ends with an error.
std::optional<std::string> output_of(const std::string& program, const std::string& option) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return std::nullopt;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::string name = program;
  std::string argument = option;
  std::array<char*, 3> words{name.data(), argument.data(), nullptr};
  pid_t child = 0;
  const bool started = posix_spawn(&child, program.c_str(), &actions, nullptr, words.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 1; started && got > 0;) {
    got = read(ends[0], buffer.data(), buffer.size());
    if (got > 0) text.append(buffer.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  if (!started) return std::nullopt;
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? std::optional(text) : std::nullopt;
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

Finding check_devices(const std::string& program) {
  const std::optional<std::string> table = output_of(program, "--list-render-devices");
  if (!table) return {Level::kProblem, "pictures", program + " --list-render-devices failed", "install kerfd again"};
  std::string chosen = first_line(*table);
  std::istringstream lines(*table);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" * ") != std::string::npos) chosen = line.substr(line.find(" * ") + 3);
  }
  if (table->rfind("none", 0) == 0) {
    return {Level::kWarning, "pictures", "no device draws: " + chosen,
            "apt install libegl1 libegl-mesa0 libgl1-mesa-dri; without pictures all else works"};
  }
  return {Level::kOk, "pictures", chosen, ""};
}

}  // namespace

const char* name_of(Level level) {
  switch (level) {
    case Level::kOk:
      return "ok";
    case Level::kWarning:
      return "warning";
    case Level::kProblem:
      return "problem";
  }
  return "";
}

Finding check_processors(std::int32_t count) {
  const std::string text = std::to_string(count) + (count == 1 ? " processor" : " processors");
  if (count >= 2) return {Level::kOk, "processors", text, ""};
  return {Level::kWarning, "processors", text, "two or more let sheets step while frames are sent"};
}

Finding check_memory(std::int64_t bytes) {
  if (bytes == 0)
    return {Level::kWarning, "memory", "unknown: /proc/meminfo cannot be read", "give kerfd --max-total-vertices"};
  const std::string text = gigabytes(static_cast<double>(bytes)) + " may be used";
  if (bytes >= kGigabyte) return {Level::kOk, "memory", text, ""};
  return {Level::kWarning, "memory", text,
          "kerfd plans with half of it, 8 kB a vertex: raise the limit for large sheets"};
}

Finding check_open_files(std::int64_t most) {
  const std::string text = "at most " + std::to_string(most) + " at a time";
  const std::string advice = "raise it: ulimit -Hn 65536, or LimitNOFILE=65536 in the systemd unit";
  if (most < kFewFiles) return {Level::kProblem, "open files", text, advice};
  if (most < kUsualFiles) return {Level::kWarning, "open files", text + ", which is few for many viewers", advice};
  return {Level::kOk, "open files", text, ""};
}

Finding check_data_folder(const std::string& folder) {
  const std::string name = "data folder";
  if (folder.empty()) {
    return {Level::kProblem, name, "unknown, as neither XDG_DATA_HOME nor HOME is set",
            "give kerfd --data DIR or --data none"};
  }
  std::error_code wrong;
  std::filesystem::path there = std::filesystem::absolute(folder, wrong);
  while (!std::filesystem::exists(there, wrong) && there.has_relative_path()) there = there.parent_path();
  if (!std::filesystem::is_directory(there, wrong)) {
    return {Level::kProblem, name, folder + ": " + there.string() + " is no folder", "give kerfd another --data DIR"};
  }
  if (access(there.c_str(), W_OK | X_OK) != 0) {
    return {Level::kProblem, name, folder + " cannot be written: " + error_text(errno),
            "let the user that runs kerfd write " + there.string() + ", or give --data DIR"};
  }
  struct statvfs space {};
  if (statvfs(there.c_str(), &space) != 0) return {Level::kOk, name, folder + " can be written", ""};
  const double free = static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize);
  const std::string text = folder + " can be written, " + gigabytes(free) + " free";
  if (free >= static_cast<double>(kGigabyte)) return {Level::kOk, name, text, ""};
  return {Level::kWarning, name, text, "free some space: kerfd refuses changes of kept sheets once the disk is full"};
}

Finding check_certificate(const std::string& option, const std::string& file, std::int64_t now_s) {
  const std::string name = "certificate";
  const std::string which = option + " " + file;
  const std::unique_ptr<BIO, int (*)(BIO*)> bio(BIO_new_file(file.c_str(), "r"), BIO_free);
  if (!bio) return {Level::kProblem, name, which + " cannot be read", "check its path and its permissions"};
  const std::unique_ptr<X509, void (*)(X509*)> certificate(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr),
                                                           X509_free);
  if (!certificate)
    return {Level::kProblem, name, which + " has no certificate in PEM form", "convert it: openssl x509"};
  const auto seconds = [](const ASN1_TIME* time) {
    std::tm parts{};
    ASN1_TIME_to_tm(time, &parts);
    return std::int64_t{timegm(&parts)};
  };
  const std::int64_t begin = seconds(X509_get0_notBefore(certificate.get()));
  const std::int64_t end = seconds(X509_get0_notAfter(certificate.get()));
  if (end <= now_s)
    return {Level::kProblem, name, which + " expired on " + date_of(end), "renew it, then send kerfd SIGHUP"};
  if (begin > now_s) {
    return {Level::kProblem, name, which + " is valid only from " + date_of(begin), "check the clock of this machine"};
  }
  const std::string text = which + " is valid until " + date_of(end);
  if (end - now_s >= kSoon_s) return {Level::kOk, name, text, ""};
  return {Level::kWarning, name, text, "renew it, then send kerfd SIGHUP"};
}

Finding check_token_file(const std::string& file) {
  struct stat about {};
  if (stat(file.c_str(), &about) != 0) {
    return {Level::kProblem, "token", file + " cannot be read: " + error_text(errno), "make one: kerf token new"};
  }
  if ((about.st_mode & (S_IRGRP | S_IROTH)) != 0) {
    return {Level::kWarning, "token", file + " can be read by other users", "chmod 600 " + file};
  }
  return {Level::kOk, "token", file + " is yours alone", ""};
}

Finding check_port(const std::string& name, const std::string& address, bool taken_by_kerf) {
  if (taken_by_kerf) return {Level::kOk, name, address + " is that of the server", ""};
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int unknown = colon == std::string::npos
                          ? EAI_SERVICE
                          : getaddrinfo(host.c_str(), address.substr(colon + 1).c_str(), &hints, &found);
  if (unknown != 0) {
    return {Level::kProblem, name, address + " is no address: " + gai_strerror(unknown), "write HOST:PORT"};
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, freeaddrinfo);
  const int socket_of = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  setsockopt(socket_of, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  const int error = socket_of < 0 || bind(socket_of, found->ai_addr, found->ai_addrlen) != 0 ? errno : 0;
  close(socket_of);
  if (error == 0) return {Level::kOk, name, address + " is free", ""};
  if (error == EADDRNOTAVAIL) return {Level::kOk, name, address + " is on another machine", ""};
  return {error == EADDRINUSE ? Level::kWarning : Level::kProblem, name, address + ": " + error_text(error),
          "give kerfd another address: --listen HOST:PORT, --http HOST:PORT"};
}

std::vector<Finding> check_server_program(const std::string& program, const std::string& version) {
  if (program.empty()) {
    return {{Level::kWarning, "kerfd", "not found beside kerf or in PATH", "install it if the server is to run here"}};
  }
  const std::optional<std::string> says = output_of(program, "--version");
  if (!says) return {{Level::kProblem, "kerfd", program + " cannot be started", "install it again"}};
  const std::string found = first_line(*says);
  if (found != "kerfd " + version) {
    return {{Level::kWarning, "kerfd", program + " is " + found + ", and this is kerf " + version,
             "install both of one version"},
            check_devices(program)};
  }
  return {{Level::kOk, "kerfd", program + ", version " + version, ""}, check_devices(program)};
}

std::string find_server_program() {
  std::error_code unknown;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", unknown);
  std::vector<std::filesystem::path> folders{self.parent_path()};
  const char* path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe)
  std::istringstream parts(path == nullptr ? "" : path);
  for (std::string part; std::getline(parts, part, ':');) folders.emplace_back(part);
  for (const std::filesystem::path& folder : folders) {
    const std::filesystem::path program = folder / "kerfd";
    if (!folder.empty() && access(program.c_str(), X_OK) == 0) return program.string();
  }
  return {};
}

std::string default_data_folder() {
  const char* data = std::getenv("XDG_DATA_HOME");  // NOLINT(concurrency-mt-unsafe)
  if (data != nullptr && *data == '/') return std::string(data) + "/kerf";
  const char* home = std::getenv("HOME");  // NOLINT(concurrency-mt-unsafe)
  return home == nullptr || *home == '\0' ? std::string() : std::string(home) + "/.local/share/kerf";
}

}  // namespace kerf::cli
