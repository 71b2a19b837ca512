#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

// Clients made of bare sockets, which may also say what no library would. Every wait ends after kPatienceS seconds.
namespace kerf::ws_test {

inline constexpr int kPatienceS = 20;

struct Response {
  int status = 0;                              // 0: none came
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
};

class RawClient {
 public:
  explicit RawClient(int port);  // of 127.0.0.1
  // From another address of this machine, such as 127.0.0.2.
  RawClient(int port, const char* from);
  virtual ~RawClient();
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool send(std::string_view bytes);
  // Up to and including `end`; nothing if the peer closes first.
  std::optional<std::string> read_until(std::string_view end);
  std::optional<std::string> read_exactly(std::size_t bytes);
  // The next response; its body by Content-Length, none for `head`.
  Response read_response(bool head = false);
  // All that comes until the peer closes.
  std::string read_rest();
  // Waits; true if the peer closes (or resets) and nothing more comes before it.
  bool closed_by_peer();
  void hang_up();
  // Closes this half of the connection: nothing more is sent, answers still come.
  void end_sending();
  // Makes the kernel keep no more than about this much that is not read.
  void shrink_receive_buffer(int bytes);

 protected:
  // The number of bytes that the socket took or gave; 0 or less at the end of the connection.
  virtual ssize_t write_some(std::string_view bytes);
  virtual ssize_t read_some(char* bytes, std::size_t size);
  [[nodiscard]] int socket() const { return socket_; }

 private:
  bool receive();

  int socket_ = -1;
  std::string buffer_;
};

// One request on a connection of its own. `headers`: whole lines, each ending in CRLF, beside Host and Content-Length.
Response request(int port, std::string_view method, std::string_view target, std::string_view headers = {},
                 std::string_view body = {});
// The same on `client`, which is connected to 127.0.0.1:`port` and stays open.
Response request(RawClient& client, int port, std::string_view method, std::string_view target,
                 std::string_view headers = {}, std::string_view body = {});
// GET of `target` on `client`, which stays open.
Response get(RawClient& client, std::string_view target);

// RFC 6455.
class RawWebSocket {
 public:
  enum Opcode : std::uint8_t { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };
  struct Frame {
    bool final = true;
    std::uint8_t reserved = 0;  // the three reserved bits
    std::uint8_t opcode = 0;
    std::string payload;
  };

  // Sends the opening handshake to `path` and reads the answer. `headers` replaces the usual Sec-WebSocket-Protocol and
  // Origin lines.
  RawWebSocket(int port, std::string_view headers = "Sec-WebSocket-Protocol: kerf.v1\r\n",
               std::string_view path = "/watch");
  // The same on `connection`, which is connected to 127.0.0.1:`port`.
  RawWebSocket(std::unique_ptr<RawClient> connection, int port, std::string_view headers, std::string_view path);

  [[nodiscard]] const Response& handshake() const { return handshake_; }
  void send(std::uint8_t opcode, std::string_view payload, bool masked = true, std::uint8_t first_bits = 0x80);
  // The next frame, pings answered on the way; nothing if the connection ends.
  std::optional<Frame> read();
  // Reads on to the close frame, answers it, hangs up and returns its code; 0 if the connection ends without one, 1005
  // if it has none.
  int read_close();
  RawClient& connection() { return *connection_; }

 private:
  std::unique_ptr<RawClient> connection_;
  Response handshake_;
};

}  // namespace kerf::ws_test
