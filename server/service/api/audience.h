#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "kerf/v1/stream.pb.h"
#include "server/service/auth/grant.h"
#include "server/service/host/clock.h"

namespace kerf::api {

// Lists who watches each sheet, what callers did to it, and where its viewers point. Thread-safe.
class Audience : public std::enable_shared_from_this<Audience> {
 public:
  static constexpr std::size_t kMaxListedViewers = 64;
  static constexpr std::size_t kMaxActivities = 32;  // of each sheet
  static constexpr std::size_t kMaxPointing = 8;     // viewers of a sheet that point at the same time
  // Time between two turns in which the streams of a sheet get what is new. What changes in between comes together.
  static constexpr host::Nanoseconds kTurn = std::chrono::milliseconds(50);

  explicit Audience(host::Clock& clock) : clock_(clock) {}
  Audience(const Audience&) = delete;
  Audience& operator=(const Audience&) = delete;

  // The place of one stream among those who watch a sheet, until it is destroyed.
  class Seat;
  // Takes a seat. `wake`: called without a lock in each turn with something new, until the seat is destroyed; null: the
  // stream asks for nothing. `pictures`: it gets pictures alone.
  std::shared_ptr<Seat> join(const std::string& sheet, const auth::Caller& caller, bool pictures,
                             std::function<void()> wake);

  // Adds what a caller did to a sheet. `call`: name of the call.
  void add(const std::string& sheet, const auth::Caller& caller, const std::string& call);
  // Forgets what callers did to a sheet that is gone.
  void forget(const std::string& sheet);

 private:
  struct Member {
    v1::Viewer viewer;
    std::function<void()> wake;
    std::optional<v1::Vec2> pointer;   // where it points
    std::int64_t pointer_version = 0;  // of its last change; 0: it never pointed
  };
  struct OfSheet {
    std::map<std::int32_t, Member> members;  // by number
    std::int64_t members_version = 0;
    std::deque<v1::Activity> activities;
    std::int64_t num_activities = 0;  // all of them, also the forgotten ones
    std::int64_t num_turns = 0;
    host::Nanoseconds last_turn{0};
    bool is_turn_planned = false;
  };
  using Wakes = std::vector<std::function<void()>>;

  // These need mutex_ held. Something of a sheet has changed: returns whom to wake now, or plans a turn.
  Wakes changed(const std::string& name, OfSheet& sheet);
  Wakes begin_turn(OfSheet& sheet);
  static std::size_t num_pointing(const OfSheet& sheet);
  void remove_unused(const std::string& sheet);

  void take_planned_turn(const std::string& sheet);

  void leave(const std::string& sheet, std::int32_t number);

  host::Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, OfSheet> sheets_;
  std::int32_t num_joined_ = 0;
  std::int64_t last_version_ = 0;  // of anything
};

class Audience::Seat {
 public:
  Seat(std::shared_ptr<Audience> audience, std::string sheet, std::int32_t number)
      : audience_(std::move(audience)), sheet_(std::move(sheet)), number_(number) {}
  ~Seat() { audience_->leave(sheet_, number_); }
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

  // Returns the next message for this stream; nothing if there is none. For one thread at a time.
  std::optional<v1::WatchResponse> next();
  // Shows the others where this viewer points; without a material position, that it does no longer.
  void point(const v1::Pointer& pointer);

 private:
  const std::shared_ptr<Audience> audience_;
  const std::string sheet_;
  const std::int32_t number_;
  // These mark what next() has given.
  std::int64_t turn_seen_ = 0;     // number of the last turn of which everything was given
  std::int64_t members_seen_ = 0;  // version
  std::int64_t activities_seen_ = 0;
  std::int64_t pointers_seen_ = 0;  // version
};

}  // namespace kerf::api
