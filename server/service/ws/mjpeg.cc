#include "server/service/ws/mjpeg.h"

#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <functional>
#include <string>

#include "server/service/ws/wake_event.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;

constexpr int kUnsentBytes = 16 << 10;

// The boundary of the next part is written directly after a picture, because browsers show a picture only once they
// have seen it.
constexpr std::string_view kHead =
    "HTTP/1.1 200 OK\r\n"
    "Server: kerfd\r\n"
    "Content-Type: multipart/x-mixed-replace; boundary=kerf-picture\r\n"
    "Cache-Control: no-store\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Connection: close\r\n";
constexpr std::string_view kResourcePolicy = "Cross-Origin-Resource-Policy";
constexpr std::string_view kFirstPart = "\r\n--kerf-picture\r\n";
constexpr std::string_view kNextPart = "\r\n--kerf-picture\r\n";

// Makes a write wait until all but about kUnsentBytes have left the machine, regardless of the send buffer. TCP ends
// the connection if sent data is not acknowledged within `write_timeout`: the write of a small picture does not wait
// for that.
void set_options(PlainStream& stream, std::chrono::milliseconds write_timeout) {
  const int socket = stream.socket().native_handle();
  ::setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentBytes, sizeof(kUnsentBytes));
  const auto timeout_ms = static_cast<unsigned>(write_timeout.count());
  ::setsockopt(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, &timeout_ms, sizeof(timeout_ms));
}

template <typename Stream>
asio::awaitable<bool> write_part(Stream& stream, const std::string& picture, const std::string& before) {
  const std::string head =
      before + "Content-Type: image/jpeg\r\nContent-Length: " + std::to_string(picture.size()) + "\r\n\r\n";
  const std::array<asio::const_buffer, 3> parts = {asio::buffer(head), asio::buffer(picture),
                                                   asio::buffer(kNextPart.data(), kNextPart.size())};
  boost::system::error_code error;
  co_await asio::async_write(stream, parts, asio::redirect_error(asio::use_awaitable, error));
  co_return !error;
}

// Returns all that comes before the first picture.
std::string beginning(const HeaderLines& headers) {
  std::string all(kHead);
  bool says_resource_policy = false;
  for (const auto& [name, value] : headers) {
    all += name + ": " + value + "\r\n";
    says_resource_policy = says_resource_policy || name == kResourcePolicy;
  }
  if (!says_resource_policy) all += std::string(kResourcePolicy) + ": same-origin\r\n";
  return all + std::string(kFirstPart);
}

Error no_picture(const api::ImageSession& session) {
  if (std::optional<Error> failure = session.failure()) return *std::move(failure);
  return unavailable("STREAM_ENDED", "the sheet was deleted, or the server is stopping, before the first picture");
}

}  // namespace

template <typename Stream>
asio::awaitable<std::optional<Error>> play_mjpeg(std::shared_ptr<api::ImageSession> session, Stream& stream,
                                                 MjpegTimes times, HeaderLines headers, std::stop_token hung_up) {
  const std::string first = beginning(headers);
  const auto woken = std::make_shared<WakeEvent>(stream.get_executor());
  const std::function<void()> wake = [woken, executor = stream.get_executor()] {
    asio::post(executor, [woken] { woken->raise(); });
  };
  const std::stop_callback<std::function<void()>> on_hang_up(hung_up, wake);
  session->set_wake(wake);
  PlainStream& lowest = beast::get_lowest_layer(stream);
  set_options(lowest, times.write_timeout);
  stream::Bytes last;  // Null: nothing was sent.
  bool repeat = false;
  bool open = true;
  while (open && !hung_up.stop_requested()) {
    const bool ended = session->ended();
    std::optional<stream::Bytes> picture = session->next_picture();
    if (!picture && repeat && !ended) picture = last;
    repeat = false;
    if (picture) {
      lowest.expires_after(times.write_timeout);
      // Not a temporary of the co_await, which g++ 12 would destroy twice.
      const std::string before = last == nullptr ? first : std::string();
      open = co_await write_part(stream, **picture, before);
      last = *picture;
    } else if (ended) {
      open = false;
    } else if (!session->ended()) {
      const bool raised = co_await woken->wait_for(times.repeat_after);
      repeat = !raised && last != nullptr;
    }
  }
  session->set_wake({});
  session->close();
  std::optional<Error> refusal;
  if (last == nullptr) refusal = no_picture(*session);
  co_return refusal;
}

template asio::awaitable<std::optional<Error>> play_mjpeg(std::shared_ptr<api::ImageSession>, PlainStream&, MjpegTimes,
                                                          HeaderLines, std::stop_token);
template asio::awaitable<std::optional<Error>> play_mjpeg(std::shared_ptr<api::ImageSession>, TlsStream&, MjpegTimes,
                                                          HeaderLines, std::stop_token);

}  // namespace kerf::ws
