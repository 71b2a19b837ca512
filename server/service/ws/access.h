#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"

namespace kerf::ws {

// HOST:PORT, the host without the brackets of an IPv6 address.
struct Endpoint {
  std::string host;
  int port = 0;  // 0..65535
};

// "127.0.0.1:8080", "localhost:0", "[::1]:8080". INVALID_ARGUMENT otherwise.
Result<Endpoint> parse_endpoint(std::string_view text);
// Brackets around an IPv6 address.
std::string format_endpoint(std::string_view host, int port);

// True of "localhost", 127.0.0.0/8 and ::1: names and addresses that only this machine can reach.
bool is_loopback(std::string_view host);

// Which web pages may talk to this server. Browsers send `Origin` with every WebSocket handshake and every POST, and
// scripts of other sites cannot forge it.
struct AccessPolicy {
  bool bound_to_loopback = true;
  std::vector<std::string> allowed_origins;  // e.g. "https://viewer.example.org"; their hosts may also be named in Host
  int port = 0;                              // that the server listens at
};

// The value of the Host header. On a loopback bind it has to name this machine: else a site whose DNS entry was pointed
// at 127.0.0.1 (DNS rebinding) would count as the same origin. PERMISSION is told as FAILED_PRECONDITION with reason
// HOST_NOT_ALLOWED; an empty or malformed one is INVALID_ARGUMENT.
Status check_host(const AccessPolicy& policy, std::string_view host);

// Takes the value of the Origin header, empty where there is none (a program that is no browser: allowed). Allowed are
// the policy's list and the server's own pages, which come over http: from the host and port that Host names, and on a
// loopback bind also from localhost, 127.0.0.1 and ::1 at the server's port. Other web servers of this machine, and
// https, are strangers. Else FAILED_PRECONDITION with reason ORIGIN_NOT_ALLOWED.
Status check_origin(const AccessPolicy& policy, std::string_view origin, std::string_view host);

}  // namespace kerf::ws
