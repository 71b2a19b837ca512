#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/base/result.h"
#include "server/host/host.h"
#include "server/stream/channel.h"

namespace kerf::api {

// One channel for each sheet that is watched, tied to the host while anybody watches. Thread-safe.
class StreamHub {
 public:
  StreamHub(host::Host& host, std::int32_t max_subscribers, std::string instance)
      : host_(host), max_subscribers_(max_subscribers), instance_(std::move(instance)) {}

  using Joined = std::function<void(Result<std::shared_ptr<stream::Subscriber>>)>;
  // `joined` is called once, here or on a thread of the host; `ready` as by stream::Channel::subscribe(), possibly
  // before. Errors of subscribe() and of host::Host::add_sink().
  void join(const std::string& sheet_id, const stream::SubscriberOptions& options, std::function<void()> ready,
            Joined joined);
  // To be called once for each subscriber that join() gave.
  void leave(const std::string& sheet_id, stream::Subscriber& subscriber);

  // Ends all streams with kServerStopping; join() is refused from now on.
  void stop();

 private:
  struct Waiting {
    std::shared_ptr<stream::Subscriber> subscriber;
    Joined joined;
  };
  struct Entry {
    std::shared_ptr<stream::Channel> channel;
    bool attached = false;         // the host publishes to it
    std::vector<Waiting> waiting;  // until it is
  };

  void attach(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel);
  void attached(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel, const Status& status);

  host::Host& host_;
  const std::int32_t max_subscribers_;
  const std::string instance_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
  bool stopped_ = false;
};

}  // namespace kerf::api
