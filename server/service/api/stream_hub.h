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
#include "server/service/host/clock.h"
#include "server/service/host/host.h"
#include "server/service/stream/channel.h"

namespace kerf::api {

// Keeps one channel for each watched sheet, attached to the host while it has readers. Thread-safe.
class StreamHub {
 public:
  StreamHub(host::Host& host, std::int32_t max_subscribers, std::string instance, host::Clock& clock)
      : host_(host), max_subscribers_(max_subscribers), instance_(std::move(instance)), clock_(clock) {}

  // Makes a reader of the sheet's channel; called once, or not at all if the server is stopping.
  using Subscribe = std::function<Result<std::shared_ptr<stream::Reader>>(const std::shared_ptr<stream::Channel>&)>;
  using Joined = std::function<void(Result<std::shared_ptr<stream::Reader>>)>;
  // Joins a reader. `joined` is called once, here or on a thread of the host. Errors of `subscribe` and of
  // host::Host::add_sink().
  void join(const std::string& sheet_id, const Subscribe& subscribe, Joined joined);
  // Removes a reader; to be called once for each reader that join() gave.
  void leave(const std::string& sheet_id, stream::Reader& reader);
  // Has the newest snapshot published again, because a reader wants strains or values, which that snapshot may lack, or
  // a newer snapshot.
  void refresh(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel);

  // Counters of all channels, past and present.
  [[nodiscard]] const stream::FrameCounters& counters() const { return *counters_; }

  // Ends all streams with kServerStopping; join() is refused from now on.
  void stop();

 private:
  struct Waiting {
    std::shared_ptr<stream::Reader> reader;
    Joined joined;
  };
  struct Entry {
    std::shared_ptr<stream::Channel> channel;
    bool attached = false;         // The host publishes to it.
    std::vector<Waiting> waiting;  // Waiting until it is attached.
  };

  void attach(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel);
  void attached(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel, const Status& status);

  host::Host& host_;
  const std::int32_t max_subscribers_;
  const std::string instance_;
  host::Clock& clock_;
  const std::shared_ptr<stream::FrameCounters> counters_ = std::make_shared<stream::FrameCounters>();
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
  bool stopped_ = false;
};

}  // namespace kerf::api
