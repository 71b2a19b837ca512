#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/service/ws/access.h"

// Cross-origin resource sharing (https://fetch.spec.whatwg.org/#http-cors-protocol): tells browsers which pages of
// other origins may read the answers of this server, and what they may send.
namespace kerf::ws {

using HeaderLines = std::vector<std::pair<std::string, std::string>>;

// Adds to the headers of an answer to a request with this Origin header. Only pages of allowed origins get any but
// Vary. Their origin is named, never "*", so that they may also use a login.
void share_with_origin(const AccessPolicy& policy, std::string_view origin, HeaderLines& headers);

// Returns the headers of the answer to a preflight of a page of an allowed origin. `asks_private_network`: value of
// Access-Control-Request-Private-Network.
HeaderLines preflight_headers(std::string_view asks_private_network);

}  // namespace kerf::ws
