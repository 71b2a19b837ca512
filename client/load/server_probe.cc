#include "client/load/server_probe.h"

#include <chrono>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>

#include "client/load/endpoint.h"
#include "client/load/metrics_text.h"
#include "client/load/tls.h"

namespace kerf::load {
namespace {

constexpr std::int32_t kPageSize = 1000;
constexpr std::chrono::seconds kHttpPatience(5);
constexpr std::size_t kMaxMetrics = std::size_t{4} << 20;  // Bytes.

}  // namespace

std::map<std::string, SheetCounts> ServerProbe::sheets() {
  std::map<std::string, SheetCounts> found;
  v1::ListSheetsRequest request;
  request.set_page_size(kPageSize);
  const std::string ours = "sheets/" + plan_.prefix + "-";
  pages_ = 0;
  const Nanoseconds begin = now();
  do {
    v1::ListSheetsResponse page;
    const grpc::Status status = client_.call(&v1::SheetService::Stub::ListSheets, client_.sheets(), request, page);
    if (!status.ok()) {
      failure_ = status;
      return {};
    }
    ++pages_;
    for (const v1::Sheet& sheet : page.sheets()) {
      if (sheet.name().compare(0, ours.size(), ours) != 0) continue;
      found[sheet.name()] = {sheet.tick(), sheet.overruns(), sheet.slipped_s(),
                             v1::Sheet::RunState_Name(sheet.run_state())};
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  listing_took_ = now() - begin;
  return found;
}

void add_sums(const std::map<std::string, SheetCounts>& sheets, Probe& probe) {
  for (const auto& [name, sheet] : sheets) {
    probe.ticks += sheet.tick;
    probe.overruns += sheet.overruns;
    probe.slipped_s += sheet.slipped_s;
  }
}

Probe ServerProbe::probe() {
  Probe probe;
  probe.time = now();
  v1::ServerInfo info;
  const grpc::Status status =
      client_.call(&v1::ServerService::Stub::GetServerInfo, client_.server(), v1::GetServerInfoRequest(), info);
  if (status.ok()) {
    probe.load = info.load();
  } else {
    failure_ = status;
  }
  if (plan_.server_pid > 0) probe.server = usage_of(plan_.server_pid);
  if (!plan_.http.empty()) {
    if (const std::optional<std::string> page = http_get(plan_.http, "/metrics", plan_.secrets)) {
      if (!probe.server) probe.server = usage_in(*page);
      probe.frames_encoded = metric_in(*page, "kerf_frames_encoded_total");
    }
  }
  probe.client = own_usage();
  return probe;
}

std::optional<std::string> http_get(const std::string& address, const std::string& target,
                                    const client::Secrets& secrets) {
  namespace asio = boost::asio;
  namespace beast = boost::beast;
  const std::optional<Endpoint> endpoint = parse_endpoint(address);
  if (!endpoint) return std::nullopt;
  asio::io_context context;
  asio::ssl::context tls(asio::ssl::context::tls_client);
  if (secrets.use_tls && prepare(secrets, tls)) return std::nullopt;
  TlsStream stream(context, tls);  // Without TLS only the one below it is used.
  if (secrets.use_tls) expect_server(secrets, endpoint->host, stream);
  boost::system::error_code error;
  const auto found = asio::ip::tcp::resolver(context).resolve(endpoint->host, endpoint->port, error);
  if (error) return std::nullopt;
  // Uses asynchronous calls, because blocking ones have no time limit.
  stream.next_layer().expires_after(kHttpPatience);
  beast::http::request<beast::http::empty_body> request(beast::http::verb::get, target, 11);
  request.set(beast::http::field::host, address);
  if (!secrets.token.empty()) request.set(beast::http::field::authorization, "Bearer " + secrets.token);
  beast::http::response_parser<beast::http::string_body> answer;
  answer.body_limit(kMaxMetrics);
  beast::flat_buffer buffer;
  bool read = false;
  const auto ask = [&](auto& way) {
    beast::http::async_write(way, request, [&](const boost::system::error_code& unsent, std::size_t /*bytes*/) {
      if (unsent) return;
      beast::http::async_read(way, buffer, answer,
                              [&](const boost::system::error_code& unread, std::size_t /*bytes*/) { read = !unread; });
    });
  };
  stream.next_layer().async_connect(found, [&](const boost::system::error_code& failed, const auto& /*endpoint*/) {
    if (failed) return;
    if (!secrets.use_tls) return ask(stream.next_layer());
    stream.async_handshake(asio::ssl::stream_base::client, [&](const boost::system::error_code& refused) {
      if (!refused) ask(stream);
    });
  });
  context.run();
  if (!read || answer.get().result() != beast::http::status::ok) return std::nullopt;
  return answer.get().body();
}

}  // namespace kerf::load
