#include "server/service/rpc/grpc_caller.h"

#include <gtest/gtest.h>

namespace kerf::rpc {
namespace {

TEST(AddressIn, HasNoSchemeAndNoPort) {
  EXPECT_EQ(address_in("ipv4:192.0.2.7:4711"), "192.0.2.7");
  EXPECT_EQ(address_in("ipv6:%5B2001:db8::7%5D:4711"), "2001:db8::7");
  EXPECT_EQ(address_in("unix:"), "unix:");
  EXPECT_EQ(address_in(""), "");
}

}  // namespace
}  // namespace kerf::rpc
