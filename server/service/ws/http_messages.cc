#include "server/service/ws/http_messages.h"

#include <boost/beast/http/error.hpp>
#include <boost/beast/http/write.hpp>

#include <sstream>

namespace kerf::ws {

namespace beast = boost::beast;
namespace http = beast::http;

std::string header(const RequestMessage& request, http::field field) {
  const beast::string_view value = request[field];
  return {value.data(), value.size()};
}

namespace {

std::string header_named(const RequestMessage& request, const char* name) {
  const beast::string_view value = request[name];
  return {value.data(), value.size()};
}

}  // namespace

HttpRequest head_of(const RequestMessage& message) {
  return {std::string(message.method_string()),
          std::string(message.target()),
          header(message, http::field::host),
          header(message, http::field::origin),
          header(message, http::field::if_none_match),
          header(message, http::field::accept_encoding),
          header(message, http::field::authorization),
          header(message, http::field::cookie),
          header_named(message, "x-kerf-csrf"),
          header_named(message, "x-forwarded-for"),
          header_named(message, "access-control-request-private-network"),
          {},
          {}};
}

HttpRequest to_request(RequestMessage& message) {
  HttpRequest request = head_of(message);
  request.body = std::move(message.body());
  return request;
}

HttpResponse body_too_large() {
  HttpResponse response = refusal(resource_exhausted("REQUEST_TOO_LARGE",
                                                     "the request's body exceeds the limit here: send less in one "
                                                     "call; send a mesh file to POST /sheets, at most 64 MiB"));
  response.status = 413;
  return response;
}

std::optional<HttpResponse> unreadable_request(const boost::system::error_code& error) {
  if (error == http::error::body_limit) return body_too_large();
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    HttpResponse response = refusal(resource_exhausted("HEADER_TOO_LARGE", "the request's header exceeds the limit"));
    response.status = 431;
    return response;
  }
  const bool silent = error == http::error::end_of_stream || error == http::error::partial_message;
  if (silent || error.category() != http::make_error_code(http::error::bad_value).category()) return std::nullopt;
  return refusal(invalid_argument("MALFORMED_REQUEST", "not HTTP/1.1: " + error.message()));
}

std::string last_answer(const HttpResponse& response) {
  http::response<http::string_body> message{static_cast<http::status>(response.status), 11, *response.body};
  message.set(http::field::server, "kerfd");
  message.set(http::field::content_type, response.media_type);
  for (const auto& [name, value] : response.headers) message.set(name, value);
  message.keep_alive(false);
  message.prepare_payload();
  std::ostringstream bytes;
  bytes << message;
  return std::move(bytes).str();
}

}  // namespace kerf::ws
