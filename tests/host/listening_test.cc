#include "server/service/host/listening.h"

#include <gtest/gtest.h>
#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>

namespace kerf::host {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

class ListeningTest : public ::testing::Test {
 protected:
  Listening listen(const std::string& host, int port) {
    return listen_at_each(host, port, [this] { return io_.get_executor(); });
  }
  boost::system::error_code connect(const tcp::endpoint& endpoint) {
    boost::system::error_code error;
    tcp::socket(io_).connect(endpoint, error);
    return error;
  }
  asio::io_context io_;
};

// No name stands for each address that the machine has, of both families where it speaks both.
TEST_F(ListeningTest, EachAddressOfANameHasTheSamePort) {
  for (const char* name : {"localhost", ""}) {
    const Listening listening = listen(name, 0);
    ASSERT_FALSE(listening.error) << name << ": " << listening.error.message();
    const unsigned short port = listening.acceptors.front().local_endpoint().port();
    for (const tcp::acceptor& acceptor : listening.acceptors) {
      EXPECT_EQ(acceptor.local_endpoint().port(), port) << name;
      const bool is_v4 = acceptor.local_endpoint().protocol() == tcp::v4();
      EXPECT_FALSE(connect({asio::ip::make_address(is_v4 ? "127.0.0.1" : "::1"), port})) << name;
    }
  }
}

TEST_F(ListeningTest, FailsWhereThePortIsTakenAndListensNowhere) {
  const Listening first = listen("127.0.0.1", 0);
  ASSERT_FALSE(first.error);
  const Listening second = listen("localhost", first.acceptors.front().local_endpoint().port());
  EXPECT_EQ(second.error, asio::error::address_in_use);
  EXPECT_TRUE(second.acceptors.empty());
}

TEST_F(ListeningTest, FailsWhereTheAddressIsNotOfThisMachine) {
  const Listening elsewhere = listen("192.0.2.1", 0);
  EXPECT_TRUE(elsewhere.error);
  EXPECT_TRUE(elsewhere.acceptors.empty());
}

}  // namespace
}  // namespace kerf::host
