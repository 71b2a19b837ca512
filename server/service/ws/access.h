#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"

namespace kerf::ws {

// Holds HOST:PORT, the host without the brackets of an IPv6 address.
struct Endpoint {
  std::string host;
  int port = 0;  // 0..65535
};

// Parses "127.0.0.1:8080", "localhost:0" or "[::1]:8080". INVALID_ARGUMENT otherwise.
Result<Endpoint> parse_endpoint(std::string_view text);
// Formats an endpoint, with brackets around an IPv6 address.
std::string format_endpoint(std::string_view host, int port);

// True for "localhost", 127.0.0.0/8 and ::1: names and addresses that only this machine can reach.
bool is_loopback(std::string_view host);

// Decides which web pages may use this server. Browsers send `Origin` with every WebSocket handshake and every POST,
// and scripts of other sites cannot forge it.
struct AccessPolicy {
  bool bound_to_loopback = true;  // True if the server listens on loopback addresses only.
  // Origins of foreign pages that may use the server, e.g. "https://viewer.example.org". The Host header may name their
  // hosts, too.
  std::vector<std::string> allowed_origins;
  int port = 0;            // Port that the server listens at.
  bool is_secure = false;  // It speaks TLS.
};

// Returns what is wrong with an origin for AccessPolicy::allowed_origins, which has a scheme, a host and perhaps a
// port; empty if nothing is.
std::string fault_of_origin(const std::string& origin);

// Checks the value of the Host header. On a loopback bind it must name this machine. Otherwise a site whose DNS entry
// was pointed at 127.0.0.1 (DNS rebinding) would count as the same origin. FAILED_PRECONDITION with reason
// HOST_NOT_ALLOWED; an empty or malformed value is INVALID_ARGUMENT.
Status check_host(const AccessPolicy& policy, std::string_view host);

// Checks the value of the Origin header; an empty one comes from a program other than a browser and is allowed. Also
// allowed are the policy's list and the server's own pages, from the host and port in Host, over the server's own
// scheme: http, or https with TLS. On a loopback bind these may also come from localhost, 127.0.0.1 and ::1 at the
// server's port. Other web servers of this machine, and the other scheme, are foreign: FAILED_PRECONDITION with reason
// ORIGIN_NOT_ALLOWED.
Status check_origin(const AccessPolicy& policy, std::string_view origin, std::string_view host);

// Returns true if the policy's list has this value of the Origin header. Case, a slash at the end and the port that the
// scheme has by default make no difference.
bool lists_origin(const AccessPolicy& policy, std::string_view origin);

}  // namespace kerf::ws
