#include "server/service/ws/access.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>
#include <utility>

namespace kerf::ws {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(),
                         [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return result;
}

std::optional<int> parse_port(std::string_view text) {
  int port = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  if (port < 0 || port > 65535 || !std::isdigit(static_cast<unsigned char>(text.front()))) return std::nullopt;
  return port;
}

bool plausible_host(std::string_view host, bool bracketed) {
  if (host.empty() || host.size() > 253) return false;
  if (bracketed) {
    in6_addr address{};
    return inet_pton(AF_INET6, std::string(host).c_str(), &address) == 1;
  }
  return std::ranges::all_of(host, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
  });
}

// Parses "host", "host:port", "[v6]" or "[v6]:port"; a missing port is `default_port`.
std::optional<Endpoint> parse_authority(std::string_view text, std::optional<int> default_port) {
  std::string_view host = text;
  std::string_view rest;
  const bool bracketed = text.starts_with('[');
  if (bracketed) {
    const std::size_t close = text.find(']');
    if (close == std::string_view::npos) return std::nullopt;
    host = text.substr(1, close - 1);
    rest = text.substr(close + 1);
  } else if (const std::size_t colon = text.find(':'); colon != std::string_view::npos) {
    host = text.substr(0, colon);
    rest = text.substr(colon);
  }
  if (!plausible_host(host, bracketed)) return std::nullopt;
  if (rest.empty()) {
    if (!default_port) return std::nullopt;
    return Endpoint{lower(host), *default_port};
  }
  if (rest.front() != ':') return std::nullopt;
  const std::optional<int> port = parse_port(rest.substr(1));
  if (!port) return std::nullopt;
  return Endpoint{lower(host), *port};
}

struct Origin {
  std::string scheme;
  Endpoint endpoint;
};

std::optional<Origin> parse_origin(std::string_view text) {
  for (const auto& [scheme, port] : {std::pair<std::string_view, int>{"http", 80}, {"https", 443}}) {
    const std::string prefix = std::string(scheme) + "://";
    if (lower(text.substr(0, prefix.size())) != prefix) continue;
    const std::optional<Endpoint> endpoint = parse_authority(text.substr(prefix.size()), port);
    if (!endpoint) return std::nullopt;
    return Origin{std::string(scheme), *endpoint};
  }
  return std::nullopt;
}

// Parses an origin of the policy's list, which may be copied from an address bar, with a slash at its end.
std::optional<Origin> parse_listed(std::string_view text) {
  if (text.ends_with('/')) text.remove_suffix(1);
  return parse_origin(text);
}

// True if the page comes from this server itself; `host` is the value of the Host header.
bool is_own(const AccessPolicy& policy, const Origin& page, std::string_view host) {
  if (page.scheme != (policy.is_secure ? "https" : "http")) return false;
  const std::optional<Endpoint> named = parse_authority(host, policy.is_secure ? 443 : 80);
  if (named && named->host == page.endpoint.host && named->port == page.endpoint.port) return true;
  const std::string& name = page.endpoint.host;
  return policy.bound_to_loopback && page.endpoint.port == policy.port &&
         (name == "localhost" || name == "127.0.0.1" || name == "::1");
}

}  // namespace

Result<Endpoint> parse_endpoint(std::string_view text) {
  std::optional<Endpoint> endpoint = parse_authority(text, std::nullopt);
  if (!endpoint) {
    return invalid_argument("BAD_ADDRESS", "'" + std::string(text) +
                                               "' is not HOST:PORT with a port in 0..65535, "
                                               "for example 127.0.0.1:8080 or [::1]:8080");
  }
  return *std::move(endpoint);
}

std::string format_endpoint(std::string_view host, int port) {
  const bool v6 = host.find(':') != std::string_view::npos;
  return (v6 ? "[" + std::string(host) + "]" : std::string(host)) + ":" + std::to_string(port);
}

bool is_loopback(std::string_view host) {
  const std::string name = lower(host);
  if (name == "localhost") return true;
  std::array<unsigned char, sizeof(in6_addr)> address{};
  if (inet_pton(AF_INET, name.c_str(), address.data()) == 1) return address[0] == 127;
  if (inet_pton(AF_INET6, name.c_str(), address.data()) == 1) {
    return std::all_of(address.begin(), address.end() - 1, [](unsigned char byte) { return byte == 0; }) &&
           address.back() == 1;
  }
  return false;
}

Status check_host(const AccessPolicy& policy, std::string_view host) {
  const std::optional<Endpoint> endpoint = parse_authority(host, 80);
  if (!endpoint) return invalid_argument("BAD_HOST", "the Host header is missing or malformed", "Host");
  if (!policy.bound_to_loopback || is_loopback(endpoint->host)) return Nothing{};
  for (const std::string& allowed : policy.allowed_origins) {
    const std::optional<Origin> origin = parse_listed(allowed);
    if (origin && origin->endpoint.host == endpoint->host) return Nothing{};
  }
  return failed_precondition("HOST_NOT_ALLOWED",
                             "this server listens on the loopback interface and does not answer for '" +
                                 endpoint->host + "'; use its loopback address or name the origin with --allow-origin",
                             "Host");
}

std::string fault_of_origin(const std::string& origin) {
  if (parse_listed(origin)) return {};
  return "'" + origin +
         "' is not an origin; give each as the browser's address bar shows it up to the path, such as "
         "https://viewer.example.org";
}

bool lists_origin(const AccessPolicy& policy, std::string_view origin) {
  const std::optional<Origin> page = parse_origin(origin);
  if (!page) return false;
  return std::ranges::any_of(policy.allowed_origins, [&page](const std::string& text) {
    const std::optional<Origin> allowed = parse_listed(text);
    return allowed && allowed->scheme == page->scheme && allowed->endpoint.host == page->endpoint.host &&
           allowed->endpoint.port == page->endpoint.port;
  });
}

Status check_origin(const AccessPolicy& policy, std::string_view origin, std::string_view host) {
  if (origin.empty() || lists_origin(policy, origin)) return Nothing{};
  if (const std::optional<Origin> page = parse_origin(origin); page && is_own(policy, *page, host)) return Nothing{};
  return failed_precondition(
      "ORIGIN_NOT_ALLOWED",
      "pages from '" + std::string(origin.substr(0, 200)) + "' may not use this server; allow them with --allow-origin",
      "Origin");
}

}  // namespace kerf::ws
