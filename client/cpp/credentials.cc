#include "client/cpp/credentials.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace kerf::client {
namespace {

constexpr std::size_t kMaxTokenBytes = std::size_t{4} << 10;
constexpr std::size_t kMaxPemBytes = std::size_t{4} << 20;  // The system's authorities have 0.2 MB.

Failure unusable(const char* reason, const std::string& message, const char* member) {
  return {grpc::StatusCode::INVALID_ARGUMENT, reason, message, member};
}

Result<std::string> read(const std::string& path, std::size_t max_bytes, const char* member) {
  const auto unreadable = [&](const std::string& why) {
    return unusable("CREDENTIALS_UNREADABLE", "cannot read \"" + path + "\": " + why, member);
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) return unreadable(std::generic_category().message(errno));
  std::string content(max_bytes + 1, '\0');
  content.resize(std::fread(content.data(), 1, content.size(), file.get()));
  if (std::ferror(file.get()) != 0) return unreadable(std::generic_category().message(errno));
  if (content.size() > max_bytes) return unreadable("it has more than " + std::to_string(max_bytes) + " bytes");
  return content;
}

// Returns the token in the text, without the white space around it.
Result<std::string> token_in(const std::string& text, const char* member) {
  constexpr const char* kSpace = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string::npos) return unusable("TOKEN_MALFORMED", "the token is empty", member);
  std::string token = text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
  if (token.find('\n') != std::string::npos) {
    return unusable("TOKEN_MALFORMED", "there is more than one line; a token is one line", member);
  }
  if (!std::all_of(token.begin(), token.end(), [](char c) { return c >= ' ' && c <= '~'; })) {
    return unusable("TOKEN_MALFORMED", "the token has characters other than printable ASCII", member);
  }
  return token;
}

Result<std::string> read_token(const Credentials& credentials) {
  if (credentials.token_file.empty()) {
    return credentials.token.empty() ? std::string() : token_in(credentials.token, "token");
  }
  if (!credentials.token.empty()) {
    return unusable("TOKEN_GIVEN_TWICE", "give a token or a file with one, not both", "token_file");
  }
  const Result<std::string> text = read(credentials.token_file, kMaxTokenBytes, "token_file");
  return text ? token_in(*text, "token_file") : text;
}

// Returns the content of a PEM file that must have a part with this `label`; nothing without a path.
Result<std::string> read_pem(const std::string& path, std::string_view label, const char* member) {
  if (path.empty()) return std::string();
  Result<std::string> content = read(path, kMaxPemBytes, member);
  if (!content) return content;
  if (content->find("ENCRYPTED") != std::string::npos) {
    return unusable("TLS_FILE_MALFORMED", "\"" + path + "\" is encrypted; give a key without a password", member);
  }
  if (content->find("-----BEGIN ") == std::string::npos || content->find(label) == std::string::npos) {
    return unusable("TLS_FILE_MALFORMED", "\"" + path + "\" has no " + std::string(label) + " in the form of PEM",
                    member);
  }
  return content;
}

bool is_loopback_host(std::string host) {
  std::transform(host.begin(), host.end(), host.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (host == "localhost") return true;
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  in6_addr v6{};
  return inet_pton(AF_INET6, host.c_str(), &v6) == 1 && std::memcmp(&v6, &in6addr_loopback, sizeof v6) == 0;
}

// Returns the host of "HOST:PORT", "[HOST]:PORT" or a host alone; empty if the brackets are not closed before the port.
std::string host_in(const std::string& address) {
  if (address.starts_with('[')) {
    const std::size_t end = address.find(']');
    const bool is_closed = end != std::string::npos && (end + 1 == address.size() || address[end + 1] == ':');
    return is_closed ? address.substr(1, end - 1) : std::string();
  }
  const auto colons = std::count(address.begin(), address.end(), ':');
  return colons == 1 ? address.substr(0, address.find(':')) : address;
}

std::optional<Failure> check_pair(const Credentials& credentials) {
  if (!credentials.tls_cert.empty() && credentials.tls_key.empty()) {
    return unusable("TLS_PAIR_INCOMPLETE", "a certificate is given without its key", "tls_key");
  }
  if (credentials.tls_cert.empty() && !credentials.tls_key.empty()) {
    return unusable("TLS_PAIR_INCOMPLETE", "a key is given without its certificate", "tls_cert");
  }
  return std::nullopt;
}

}  // namespace

bool is_on_this_machine(const std::string& address) {
  if (address.starts_with("unix:") || address.starts_with("unix-abstract:")) return true;
  for (const std::string_view scheme : {"dns:///", "dns:", "ipv4:", "ipv6:"}) {
    if (!address.starts_with(scheme)) continue;
    std::string_view rest = std::string_view(address).substr(scheme.size());
    // Addresses with these schemes may be lists.
    while (!rest.empty()) {
      const std::size_t comma = std::min(rest.find(','), rest.size());
      if (!is_loopback_host(host_in(std::string(rest.substr(0, comma))))) return false;
      rest.remove_prefix(std::min(comma + 1, rest.size()));
    }
    return address.size() > scheme.size();
  }
  return is_loopback_host(host_in(address));
}

Result<Secrets> read_secrets(const Credentials& credentials, const std::string& address) {
  if (const std::optional<Failure> incomplete = check_pair(credentials)) return *incomplete;
  Secrets secrets;
  secrets.use_tls = credentials.use_tls || !credentials.tls_ca.empty() || !credentials.tls_cert.empty();
  secrets.tls_name = credentials.tls_name;
  const Result<std::string> token = read_token(credentials);
  if (!token) return token.failure();
  secrets.token = *token;
  struct File {
    const std::string& path;
    const char* label;
    const char* member;
    std::string& content;
  };
  for (const File& file : {File{credentials.tls_ca, "CERTIFICATE", "tls_ca", secrets.authorities},
                           File{credentials.tls_cert, "CERTIFICATE", "tls_cert", secrets.certificate},
                           File{credentials.tls_key, "PRIVATE KEY", "tls_key", secrets.key}}) {
    const Result<std::string> content = read_pem(file.path, file.label, file.member);
    if (!content) return content.failure();
    file.content = *content;
  }
  if (!secrets.token.empty() && !secrets.use_tls && !is_on_this_machine(address)) {
    return unusable("TOKEN_NEEDS_TLS",
                    "the token is not sent to " + address +
                        " in the clear, where others could read it: use TLS, or a tunnel that begins at 127.0.0.1",
                    credentials.token_file.empty() ? "token" : "token_file");
  }
  return secrets;
}

}  // namespace kerf::client
