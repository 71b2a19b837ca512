#pragma once

#include <utility>

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

#include <optional>
#include <string>

#include "server/service/ws/router.h"

// Converts between the messages of Beast and those of the Router.
namespace kerf::ws {

using RequestMessage = boost::beast::http::request<boost::beast::http::string_body>;

// Returns the value of a header; empty if it is missing.
std::string header(const RequestMessage& request, boost::beast::http::field field);

// Returns the request without its body.
HttpRequest head_of(const RequestMessage& message);
// Returns the whole request, and takes the body of `message`.
HttpRequest to_request(RequestMessage& message);

HttpResponse body_too_large();
// Returns the answer to a malformed request; nothing if the client no longer listens.
std::optional<HttpResponse> unreadable_request(const boost::system::error_code& error);

// Returns all bytes of an answer after which the connection is closed.
std::string last_answer(const HttpResponse& response);

}  // namespace kerf::ws
