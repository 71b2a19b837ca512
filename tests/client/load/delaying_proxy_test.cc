#include "client/load/delaying_proxy.h"

#include <chrono>
#include <cstddef>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "tests/support/closed_port.h"

namespace kerf::load {
namespace {

using namespace std::chrono_literals;
using Tcp = boost::asio::ip::tcp;
using Clock = std::chrono::steady_clock;

// Sends everything back.
class EchoServer {
 public:
  EchoServer() : acceptor_(context_, {boost::asio::ip::address_v4::loopback(), 0}), thread_([this] { serve(); }) {}
  ~EchoServer() { thread_.join(); }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()); }

 private:
  void serve() {
    Tcp::socket socket(context_);
    acceptor_.accept(socket);
    std::string buffer(65536, '\0');
    boost::system::error_code error;
    while (true) {
      const std::size_t bytes = socket.read_some(boost::asio::buffer(buffer), error);
      if (error) return;
      boost::asio::write(socket, boost::asio::buffer(buffer, bytes), error);
    }
  }

  boost::asio::io_context context_;
  Tcp::acceptor acceptor_;
  std::thread thread_;
};

Tcp::socket connect(boost::asio::io_context& context, const std::string& address) {
  Tcp::socket socket(context);
  const int port = std::stoi(address.substr(address.rfind(':') + 1));
  socket.connect({boost::asio::ip::address_v4::loopback(), static_cast<unsigned short>(port)});
  return socket;
}

std::string pattern(std::size_t bytes) {
  std::string text(bytes, '\0');
  for (std::size_t i = 0; i < bytes; ++i) text[i] = static_cast<char>(i * 31 % 251);
  return text;
}

// Sends and reads back at once; how long that took.
Clock::duration echo(Tcp::socket& socket, const std::string& sent) {
  const Clock::time_point begin = Clock::now();
  std::thread sender([&] { boost::asio::write(socket, boost::asio::buffer(sent)); });
  std::string received(sent.size(), '\0');
  boost::asio::read(socket, boost::asio::buffer(received));
  sender.join();
  EXPECT_EQ(received, sent);
  return Clock::now() - begin;
}

TEST(DelayingProxy, PassesEverythingOnInOrderAfterTheDelay) {
  EchoServer server;
  auto proxy = DelayingProxy::start(server.address(), {30ms, 0.0});
  ASSERT_TRUE(proxy.ok()) << proxy.error().message;
  boost::asio::io_context context;
  Tcp::socket socket = connect(context, (*proxy)->address());
  EXPECT_GE(echo(socket, "x"), 60ms);
  EXPECT_GE(echo(socket, pattern(3'000'000)), 60ms);
}

TEST(DelayingProxy, PassesNoMoreThanTheRate) {
  EchoServer server;
  auto proxy = DelayingProxy::start(server.address(), {0ms, 1.0e6});
  ASSERT_TRUE(proxy.ok()) << proxy.error().message;
  boost::asio::io_context context;
  Tcp::socket socket = connect(context, (*proxy)->address());
  EXPECT_GE(echo(socket, pattern(400'000)), 400ms);
}

// 200 ms at 4 MB/s: 800 KB are under way at a time, not 64 KiB, which would make 330 KB/s of it.
TEST(DelayingProxy, TheDelayTakesNothingFromTheRate) {
  EchoServer server;
  auto proxy = DelayingProxy::start(server.address(), {200ms, 4.0e6});
  ASSERT_TRUE(proxy.ok()) << proxy.error().message;
  boost::asio::io_context context;
  Tcp::socket socket = connect(context, (*proxy)->address());
  EXPECT_LT(echo(socket, pattern(2'000'000)), 4s);
}

// Says something and closes.
TEST(DelayingProxy, PassesOnWhatWasSaidLast) {
  boost::asio::io_context context;
  Tcp::acceptor acceptor(context, {boost::asio::ip::address_v4::loopback(), 0});
  auto proxy = DelayingProxy::start("127.0.0.1:" + std::to_string(acceptor.local_endpoint().port()), {50ms, 0.0});
  ASSERT_TRUE(proxy.ok()) << proxy.error().message;
  Tcp::socket socket = connect(context, (*proxy)->address());
  {
    Tcp::socket server = acceptor.accept();
    boost::asio::write(server, boost::asio::buffer(pattern(50'000)));
  }
  std::string received;
  boost::system::error_code error;
  boost::asio::read(socket, boost::asio::dynamic_buffer(received), error);
  EXPECT_EQ(error, boost::asio::error::eof);
  EXPECT_EQ(received, pattern(50'000));
}

TEST(DelayingProxy, OfNoServerSaysSo) {
  EXPECT_EQ(DelayingProxy::start("nonsense", {}).error().reason, "NO_PROXY");
}

TEST(DelayingProxy, ClosesWhereTheServerIsNotThere) {
  const test::ClosedPort nobody;
  auto proxy = DelayingProxy::start(nobody.address(), {});
  ASSERT_TRUE(proxy.ok());
  boost::asio::io_context context;
  Tcp::socket socket = connect(context, (*proxy)->address());
  char byte = 0;
  boost::system::error_code error;
  boost::asio::read(socket, boost::asio::buffer(&byte, 1), error);
  EXPECT_TRUE(error);
}

}  // namespace
}  // namespace kerf::load
