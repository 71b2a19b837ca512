#include "server/service/ws/write_response.h"

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/write.hpp>

#include <algorithm>
#include <chrono>
#include <string_view>

#include "server/service/ws/transport.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Message = http::response<http::span_body<const char>>;
using Serializer = http::response_serializer<http::span_body<const char>>;

// Makes browsers use https alone for this host, until a month after the last answer: RFC 6797.
constexpr const char* kOnlySecure = "max-age=2592000";

}  // namespace

template <typename Stream>
asio::awaitable<bool> write_response(Stream& stream, ConnectionContext& context, const HttpResponse& response,
                                     Framing framing) {
  ++context.requests;
  if (response.status >= 400) ++context.failed_requests;
  const std::string_view content = response.body ? std::string_view(*response.body) : std::string_view();
  Message message{static_cast<http::status>(response.status), framing.version};
  const bool is_unchanged = response.status == 304;
  const bool has_no_content = response.status == 204;  // It may have no length then (RFC 9110, 8.6).
  if (!has_no_content && (!is_unchanged || framing.head)) message.content_length(content.size());
  message.set(http::field::server, "kerfd");
  message.set("X-Content-Type-Options", "nosniff");
  message.set("Cross-Origin-Resource-Policy", "same-origin");
  if (context.is_only_secure) message.set("Strict-Transport-Security", kOnlySecure);
  if (!response.media_type.empty()) message.set(http::field::content_type, response.media_type);
  for (const auto& [name, value] : response.headers) message.set(name, value);
  message.keep_alive(framing.keep_alive);
  if (!is_unchanged && !framing.head) message.body() = beast::span<const char>(content.data(), content.size());
  Serializer serializer(message);
  const auto last = std::chrono::steady_clock::now() + context.options.response_timeout;
  boost::system::error_code error;
  while (!error && !serializer.is_done()) {
    beast::get_lowest_layer(stream).expires_at(
        std::min(last, std::chrono::steady_clock::now() + context.options.write_timeout));
    co_await http::async_write_some(stream, serializer, asio::redirect_error(asio::use_awaitable, error));
  }
  co_return !error;
}

template asio::awaitable<bool> write_response(PlainStream&, ConnectionContext&, const HttpResponse&, Framing);
template asio::awaitable<bool> write_response(TlsStream&, ConnectionContext&, const HttpResponse&, Framing);

}  // namespace kerf::ws
