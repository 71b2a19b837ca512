#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

namespace kerf::test {

// Provides an address at which no server answers: a port of this machine that is bound, but not listened on. A server
// of the test's own may be started there, and again after it has ended; no other program is given the port in between.
class ClosedPort {
 public:
  ClosedPort() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in bound{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {::htonl(INADDR_LOOPBACK)}, .sin_zero = {}};
    socklen_t size = sizeof bound;
    const int share = 1;  // with a server that shares it as well
    EXPECT_EQ(::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &share, sizeof share), 0);
    auto* address = reinterpret_cast<sockaddr*>(&bound);  // NOLINT(*-reinterpret-cast): the interface of sockets
    EXPECT_EQ(::bind(socket_, address, size), 0);
    EXPECT_EQ(::getsockname(socket_, address, &size), 0);
    number_ = ::ntohs(bound.sin_port);
    address_ = "127.0.0.1:" + std::to_string(number_);
  }
  ~ClosedPort() { ::close(socket_); }
  ClosedPort(const ClosedPort&) = delete;
  ClosedPort& operator=(const ClosedPort&) = delete;

  // HOST:PORT
  [[nodiscard]] const std::string& address() const { return address_; }
  [[nodiscard]] int number() const { return number_; }

 private:
  int socket_;
  int number_ = 0;
  std::string address_;
};

}  // namespace kerf::test
