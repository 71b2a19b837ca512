#include "tests/ws/raw_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <utility>

namespace kerf::ws_test {
namespace {

constexpr std::string_view kKey = "dGhlIHNhbXBsZSBub25jZQ==";

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return text;
}

}  // namespace

RawClient::RawClient(int port) : RawClient(port, "0.0.0.0") {}

RawClient::RawClient(int port, const char* from) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const timeval patience{kPatienceS, 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  ::inet_pton(AF_INET, from, &address.sin_addr);
  ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    ::close(socket_);
    socket_ = -1;
  }
}

RawClient::~RawClient() {
  hang_up();
}

void RawClient::end_sending() {
  ::shutdown(socket_, SHUT_WR);
}

void RawClient::hang_up() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

void RawClient::shrink_receive_buffer(int bytes) {
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof(bytes));
}

ssize_t RawClient::write_some(std::string_view bytes) {
  return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

ssize_t RawClient::read_some(char* bytes, std::size_t size) {
  return ::recv(socket_, bytes, size, 0);
}

bool RawClient::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = write_some(bytes);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool RawClient::receive() {
  std::array<char, 65536> chunk{};
  const ssize_t received = read_some(chunk.data(), chunk.size());
  if (received <= 0) return false;
  buffer_.append(chunk.data(), static_cast<std::size_t>(received));
  return true;
}

std::optional<std::string> RawClient::read_until(std::string_view end) {
  std::size_t found = buffer_.find(end);
  while (found == std::string::npos) {
    if (!receive()) return std::nullopt;
    found = buffer_.find(end);
  }
  return read_exactly(found + end.size());
}

std::optional<std::string> RawClient::read_exactly(std::size_t bytes) {
  while (buffer_.size() < bytes) {
    if (!receive()) return std::nullopt;
  }
  std::string result = buffer_.substr(0, bytes);
  buffer_.erase(0, bytes);
  return result;
}

std::string RawClient::read_rest() {
  while (receive()) {
  }
  return std::exchange(buffer_, {});
}

Response RawClient::read_response(bool head) {
  Response response;
  const std::optional<std::string> text = read_until("\r\n\r\n");
  if (!text) return response;
  response.status = std::atoi(text->substr(text->find(' ') + 1, 3).c_str());
  for (std::size_t line = text->find("\r\n") + 2; line + 2 < text->size();) {
    const std::size_t end = text->find("\r\n", line);
    const std::size_t colon = text->find(':', line);
    response.headers[lower(text->substr(line, colon - line))] = text->substr(colon + 2, end - colon - 2);
    line = end + 2;
  }
  if (const auto length = response.headers.find("content-length"); length != response.headers.end() && !head) {
    response.body = read_exactly(static_cast<std::size_t>(std::atol(length->second.c_str()))).value_or("");
  }
  return response;
}

bool RawClient::closed_by_peer() {
  std::array<char, 1> byte{};
  errno = 0;
  const ssize_t received = read_some(byte.data(), byte.size());
  return buffer_.empty() && (received == 0 || (received < 0 && errno == ECONNRESET));
}

Response request(int port, std::string_view method, std::string_view target, std::string_view headers,
                 std::string_view body) {
  RawClient client(port);
  return request(client, port, method, target, headers, body);
}

Response request(RawClient& client, int port, std::string_view method, std::string_view target,
                 std::string_view headers, std::string_view body) {
  std::string text = std::string(method) + " " + std::string(target) + " HTTP/1.1\r\n";
  if (headers.find("Host:") == std::string_view::npos) text += "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  text += headers;
  if (!body.empty()) text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  client.send(text + "\r\n" + std::string(body));
  return client.read_response(method == "HEAD");
}

Response get(RawClient& client, std::string_view target) {
  client.send("GET " + std::string(target) + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  return client.read_response();
}

RawWebSocket::RawWebSocket(int port, std::string_view headers, std::string_view path)
    : RawWebSocket(std::make_unique<RawClient>(port), port, headers, path) {}

RawWebSocket::RawWebSocket(std::unique_ptr<RawClient> connection, int port, std::string_view headers,
                           std::string_view path)
    : connection_(std::move(connection)) {
  std::string text = "GET " + std::string(path) +
                     " HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n";
  text += "Sec-WebSocket-Key: " + std::string(kKey) + "\r\n";
  if (headers.find("Host:") == std::string_view::npos) text += "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  connection_->send(text + std::string(headers) + "\r\n");
  handshake_ = connection_->read_response();
}

void RawWebSocket::send(std::uint8_t opcode, std::string_view payload, bool masked, std::uint8_t first_bits) {
  std::string frame(1, static_cast<char>(first_bits | opcode));
  const std::uint8_t mask_bit = masked ? 0x80 : 0;
  int length_bytes = 0;
  if (payload.size() < 126) {
    frame += static_cast<char>(mask_bit | payload.size());
  } else {
    length_bytes = payload.size() < 65536 ? 2 : 8;
    frame += static_cast<char>(mask_bit | (length_bytes == 2 ? 126 : 127));
  }
  for (int i = length_bytes - 1; i >= 0; --i) frame += static_cast<char>(payload.size() >> (8 * i));
  constexpr std::string_view kMask = "\x12\x34\x56\x78";
  if (masked) frame += kMask;
  for (std::size_t i = 0; i < payload.size(); ++i) {
    frame += masked ? static_cast<char>(payload[i] ^ kMask[i % 4]) : payload[i];
  }
  connection_->send(frame);
}

std::optional<RawWebSocket::Frame> RawWebSocket::read() {
  while (true) {
    const std::optional<std::string> head = connection_->read_exactly(2);
    if (!head) return std::nullopt;
    const auto first = static_cast<std::uint8_t>((*head)[0]);
    std::size_t length = static_cast<std::uint8_t>((*head)[1]) & 0x7FU;
    if (length >= 126) {
      const std::optional<std::string> extended = connection_->read_exactly(length == 126 ? 2 : 8);
      if (!extended) return std::nullopt;
      length = 0;
      for (const char byte : *extended) length = (length << 8U) | static_cast<std::uint8_t>(byte);
    }
    std::optional<std::string> payload = connection_->read_exactly(length);
    if (!payload) return std::nullopt;
    Frame frame{(first & 0x80U) != 0, static_cast<std::uint8_t>((first >> 4U) & 7U),
                static_cast<std::uint8_t>(first & 0x0FU), std::move(*payload)};
    if (frame.opcode != kPing) return frame;
    send(kPong, frame.payload);
  }
}

int RawWebSocket::read_close() {
  while (const std::optional<Frame> frame = read()) {
    if (frame->opcode != kClose) continue;
    send(kClose, frame->payload);
    connection_->hang_up();
    if (frame->payload.size() < 2) return 1005;
    return (static_cast<std::uint8_t>(frame->payload[0]) << 8) | static_cast<std::uint8_t>(frame->payload[1]);
  }
  return 0;
}

}  // namespace kerf::ws_test
