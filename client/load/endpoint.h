#pragma once

#include <optional>
#include <string>

namespace kerf::load {

struct Endpoint {
  std::string host;
  std::string port;
};

// Parses "HOST:PORT"; a host with colons needs brackets, "[::1]:50051".
inline std::optional<Endpoint> parse_endpoint(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size()) return std::nullopt;
  std::string host = text.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  if (host.empty()) return std::nullopt;
  return Endpoint{host, text.substr(colon + 1)};
}

}  // namespace kerf::load
