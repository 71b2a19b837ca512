#include "server/service/ws/cross_origin.h"

#include <algorithm>

namespace kerf::ws {
namespace {

constexpr const char* kSharedMethods = "GET, HEAD, POST";
constexpr const char* kRequestHeaders = "authorization, content-type, x-kerf-csrf";
constexpr const char* kAnswerHeaders = "content-disposition, etag, retry-after, www-authenticate";
constexpr const char* kPreflightMaxAgeS = "7200";  // The longest that Chromium takes.

std::string& value_of(HeaderLines& headers, std::string_view name) {
  const auto found = std::ranges::find_if(headers, [name](const auto& each) { return each.first == name; });
  return found != headers.end() ? found->second : headers.emplace_back(name, "").second;
}

}  // namespace

void share_with_origin(const AccessPolicy& policy, std::string_view origin, HeaderLines& headers) {
  if (policy.allowed_origins.empty()) return;
  // Answers differ by origin, so caches must keep them apart, also those without an origin.
  std::string& vary = value_of(headers, "Vary");
  vary += vary.empty() ? "Origin" : ", Origin";
  if (!lists_origin(policy, origin)) return;
  headers.emplace_back("Access-Control-Allow-Origin", origin);
  headers.emplace_back("Access-Control-Allow-Credentials", "true");
  headers.emplace_back("Access-Control-Expose-Headers", kAnswerHeaders);
  value_of(headers, "Cross-Origin-Resource-Policy") = "cross-origin";
}

HeaderLines preflight_headers(std::string_view asks_private_network) {
  HeaderLines headers = {{"Access-Control-Allow-Methods", kSharedMethods},
                         {"Access-Control-Allow-Headers", kRequestHeaders},
                         {"Access-Control-Max-Age", kPreflightMaxAgeS}};
  if (asks_private_network == "true") headers.emplace_back("Access-Control-Allow-Private-Network", "true");
  return headers;
}

}  // namespace kerf::ws
