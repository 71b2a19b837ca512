#include "server/service/ws/turned_away.h"

#include <array>
#include <chrono>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>

#include "server/service/ws/http_messages.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using NetError = boost::system::error_code;

constexpr int kMostLingering = 16;
constexpr std::chrono::seconds kLingerFor{1};
constexpr std::size_t kMostDiscarded = std::size_t{64} << 10;

std::string refusal_bytes(int most_per_address) {
  HttpResponse refused = refusal(resource_exhausted(
      "TOO_MANY_CONNECTIONS",
      "this address has " + std::to_string(most_per_address) +
          " connections open, which is the limit (kerfd --max-connections-per-address); close some, or wait"));
  refused.status = 503;
  return last_answer(refused);
}

}  // namespace

struct TurnedAway::Lingering {
  explicit Lingering(tcp::socket connected) : socket(std::move(connected)), limit(socket.get_executor()) {}
  tcp::socket socket;
  asio::steady_timer limit;
  std::array<char, 4096> discarded{};
  std::size_t num_discarded = 0;
};

TurnedAway::TurnedAway(int most_per_address) : response_(refusal_bytes(most_per_address)) {}

void TurnedAway::answer(tcp::socket socket) {
  NetError error;
  socket.non_blocking(true, error);
  if (!error) socket.send(asio::buffer(response_), 0, error);
  if (!error) socket.shutdown(tcp::socket::shutdown_send, error);
  if (error || lingering_ >= kMostLingering) return;
  ++lingering_;
  const auto lingering = std::make_shared<Lingering>(std::move(socket));
  lingering->limit.expires_after(kLingerFor);
  lingering->limit.async_wait([lingering](const NetError& cancelled) {
    NetError ignored;
    if (!cancelled) lingering->socket.close(ignored);
  });
  linger(lingering);
}

void TurnedAway::linger(const std::shared_ptr<Lingering>& lingering) {
  lingering->socket.async_read_some(asio::buffer(lingering->discarded),
                                    [this, lingering](const NetError& error, std::size_t bytes) {
                                      lingering->num_discarded += bytes;
                                      if (!error && lingering->num_discarded < kMostDiscarded) return linger(lingering);
                                      lingering->limit.cancel();
                                      --lingering_;
                                    });
}

}  // namespace kerf::ws
