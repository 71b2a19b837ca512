#include "server/service/rpc/connection_gate.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>

#include "server/app/connection_limits.h"

namespace kerf::rpc {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr auto kPatience = 30s;
constexpr auto kLong = 10min;

bool becomes_true(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

class ConnectionGateTest : public ::testing::Test {
 protected:
  void TearDown() override {
    if (gate_) gate_->stop();
    for (const int descriptor : taken()) ::close(descriptor);
  }
  void open(int max_connections, std::chrono::milliseconds silence, int max_per_address = 0) {
    const GateLimits limits{max_connections, max_per_address, silence};
    gate_ = std::make_unique<ConnectionGate>(limits, [this](int descriptor) {
      const std::lock_guard lock(mutex_);
      taken_.push_back(descriptor);
    });
    const Result<int> port = gate_->bind("127.0.0.1:0");
    ASSERT_TRUE(port.ok());
    port_ = *port;
    gate_->open();
  }
  // From another address of this machine, if one is given.
  tcp::socket connect(const char* from = "127.0.0.1") {
    tcp::socket socket(io_);
    socket.open(tcp::v4());
    socket.bind({asio::ip::make_address(from), 0});
    socket.connect({asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(port_)});
    return socket;
  }
  tcp::socket speak(const char* from = "127.0.0.1") {
    tcp::socket socket = connect(from);
    asio::write(socket, asio::buffer("hello", 5));
    return socket;
  }
  // Blocks until the gate has closed it.
  static bool is_closed(tcp::socket& socket) {
    char byte = 0;
    boost::system::error_code error;
    socket.read_some(asio::buffer(&byte, 1), error);
    return error == asio::error::eof || error == asio::error::connection_reset;
  }
  std::vector<int> taken() {
    const std::lock_guard lock(mutex_);
    return taken_;
  }
  // Closes what was taken.
  void close_all() {
    const std::lock_guard lock(mutex_);
    for (const int descriptor : taken_) ::close(descriptor);
    taken_.clear();
  }

  asio::io_context io_;
  std::mutex mutex_;
  std::vector<int> taken_;
  std::unique_ptr<ConnectionGate> gate_;
  int port_ = 0;
};

TEST_F(ConnectionGateTest, HandsOverWhatSpeaksWithAllThatItSaid) {
  open(4, kLong);
  const tcp::socket peer = speak();
  ASSERT_TRUE(becomes_true([&] { return taken().size() == 1; }));
  const int descriptor = taken().front();
  EXPECT_NE(::fcntl(descriptor, F_GETFL) & O_NONBLOCK, 0);
  std::vector<char> said(16);
  EXPECT_EQ(::read(descriptor, said.data(), said.size()), 5);
  EXPECT_EQ(gate_->counts().open, 1);
}

TEST_F(ConnectionGateTest, ClosesWhatSaysNothing) {
  open(4, 1ms);
  tcp::socket peer = connect();
  EXPECT_TRUE(is_closed(peer));
  EXPECT_TRUE(becomes_true([&] { return gate_->counts().open == 0; }));
  EXPECT_TRUE(taken().empty());
}

TEST_F(ConnectionGateTest, RefusesBeyondItsLimitAndTakesAgainWhatComesAfterAnotherHasGone) {
  open(2, kLong);
  std::vector<tcp::socket> peers;
  for (int i = 0; i < 2; ++i) peers.push_back(speak());
  ASSERT_TRUE(becomes_true([&] { return taken().size() == 2; }));
  tcp::socket third = connect();
  EXPECT_TRUE(is_closed(third));
  EXPECT_EQ(gate_->counts().refused, 1);
  close_all();
  ASSERT_TRUE(becomes_true([&] { return gate_->counts().open == 0; }));
  const tcp::socket fourth = speak();
  EXPECT_TRUE(becomes_true([&] { return taken().size() == 1; }));
  EXPECT_EQ(gate_->counts().accepted, 3);
}

TEST_F(ConnectionGateTest, OneAddressHasSoManyPlacesAndAnotherItsOwn) {
  constexpr int kPlaces = 5;
  open(64, kLong, kPlaces);
  std::vector<tcp::socket> peers;
  for (int i = 0; i < kPlaces - 1; ++i) peers.push_back(speak());
  peers.push_back(connect());  // says nothing yet, and counts
  ASSERT_TRUE(becomes_true([&] { return taken().size() == kPlaces - 1 && gate_->counts().open == kPlaces; }));
  tcp::socket one_more = connect();
  EXPECT_TRUE(is_closed(one_more));
  const tcp::socket elsewhere = speak("127.0.0.2");
  EXPECT_TRUE(becomes_true([&] { return taken().size() == kPlaces; }));
  EXPECT_EQ(gate_->counts().refused_by_address, 1);
  EXPECT_EQ(gate_->counts().refused, 0);
  peers.pop_back();  // one that was not handed over yet
  EXPECT_TRUE(becomes_true([&] { return gate_->counts().open == kPlaces; }));
  peers.push_back(speak());
  EXPECT_TRUE(becomes_true([&] { return taken().size() == kPlaces + 1; }));
  close_all();  // and those that were
  for (int i = 0; i < kPlaces; ++i) peers.push_back(speak());
  EXPECT_TRUE(becomes_true([&] { return taken().size() == kPlaces; }));
  EXPECT_EQ(gate_->counts().refused_by_address, 1);
}

TEST_F(ConnectionGateTest, WithoutALimitOneAddressMayHaveAll) {
  open(40, kLong, 0);
  std::vector<tcp::socket> peers;
  for (int i = 0; i < 40; ++i) peers.push_back(speak());
  EXPECT_TRUE(becomes_true([&] { return taken().size() == 40; }));
  EXPECT_EQ(gate_->counts().refused_by_address, 0);
}

TEST_F(ConnectionGateTest, AFloodThatHangsUpAtOnceLeavesNothing) {
  open(64, kLong);
  for (int i = 0; i < 3000; ++i) connect();
  EXPECT_TRUE(becomes_true([&] { return gate_->counts().open == 0; }));
  EXPECT_TRUE(taken().empty());
  const tcp::socket peer = speak();
  EXPECT_TRUE(becomes_true([&] { return taken().size() == 1; }));
}

TEST_F(ConnectionGateTest, StopClosesThePortAndWhatHasSaidNothing) {
  open(4, kLong);
  tcp::socket peer = connect();
  ASSERT_TRUE(becomes_true([&] { return gate_->counts().open == 1; }));
  gate_->stop();
  EXPECT_TRUE(is_closed(peer));
  EXPECT_ANY_THROW(connect());
}

TEST_F(ConnectionGateTest, ListensAtEachAddressOfAName) {
  ConnectionGate gate({4, 0, kLong}, [](int) {});
  const Result<int> port = gate.bind("localhost:0");
  ASSERT_TRUE(port.ok());
  const tcp::resolver::results_type addresses = tcp::resolver(io_).resolve("localhost", std::to_string(*port));
  int connected = 0;
  for (const auto& entry : addresses) {
    boost::system::error_code error;
    tcp::socket(io_).connect(entry.endpoint(), error);
    if (!error) ++connected;
    const bool is_spoken =
        error != asio::error::address_family_not_supported && error != asio::error::network_unreachable;
    EXPECT_TRUE(!error || !is_spoken || error == boost::system::errc::address_not_available) << entry.endpoint();
  }
  EXPECT_GT(connected, 0);
}

TEST_F(ConnectionGateTest, SharesItsPortWithNoOther) {
  open(4, kLong);
  ConnectionGate other({4, 0, kLong}, [](int) {});
  const Result<int> bound = other.bind("127.0.0.1:" + std::to_string(port_));
  ASSERT_FALSE(bound.ok());
  EXPECT_EQ(bound.error().reason, "ADDRESS_IN_USE");
}

TEST(ConnectionLimits, EachTransportHasDescriptorsOfItsOwn) {
  const app::ConnectionLimits plenty = app::connection_limits(20'000, 30, 64);
  EXPECT_EQ(plenty.grpc, 10'000);
  EXPECT_EQ(plenty.http, 1'000);
  const app::ConnectionLimits few = app::connection_limits(64, 20, 0);
  EXPECT_EQ(few.grpc, 14);
  EXPECT_EQ(few.http, 14);
  const app::ConnectionLimits none = app::connection_limits(10, 20, 64);
  EXPECT_EQ(none.grpc, 4);
  EXPECT_EQ(none.http, 4);
  for (const std::int64_t descriptors : {64, 256, 1'024, 4'096, 65'536}) {
    const app::ConnectionLimits limits = app::connection_limits(descriptors, 20, 0);
    EXPECT_LE(limits.grpc + limits.http + 20, descriptors);
  }
}

}  // namespace
}  // namespace kerf::rpc
