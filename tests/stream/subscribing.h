#pragma once

#include <functional>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "server/service/stream/channel.h"

// Subscribers of a channel, and what they are given.
namespace kerf::stream {

using namespace std::chrono_literals;

inline const auto kIgnore = [] {};

inline std::shared_ptr<Subscriber> subscribe(Channel& channel, SubscriberOptions options = {},
                                             std::function<void()> ready = kIgnore) {
  Result<std::shared_ptr<Subscriber>> subscriber = channel.subscribe(options, std::move(ready));
  EXPECT_TRUE(subscriber.ok());
  return subscriber.value();
}

inline v1::WatchResponse parse(const Message& message) {
  v1::WatchResponse response;
  EXPECT_TRUE(response.ParseFromString(message.joined()));
  return response;
}

// The next frame; a failure of the test if there is none.
inline v1::Frame frame(Subscriber& subscriber, Nanoseconds now = 0ns) {
  const Subscriber::Next next = subscriber.next(now);
  EXPECT_TRUE(next.message.has_value());
  return next.message ? parse(*next.message).frame() : v1::Frame();
}

}  // namespace kerf::stream
