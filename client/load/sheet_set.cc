#include "client/load/sheet_set.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <thread>
#include <utility>

#include "client/cpp/failure.h"

namespace kerf::load {
namespace {

constexpr int kThreads = 4;  // Threads that create and delete sheets.
constexpr std::chrono::milliseconds kRetryAfter(100);
constexpr std::chrono::milliseconds kTellEvery(250);
constexpr double kSwing_m = 0.05;     // m, of the corners to each side.
constexpr double kHalfSwing_s = 0.5;  // s, from one side to the other.
constexpr double kSpare_s = 120.0;    // s, for which the corners continue to move after the run.

// Calls `work` with 0, 1, ... n - 1 on some threads until it returns false; meanwhile calls `tell` on this one.
void share_out(std::int32_t n, const std::function<bool(std::int32_t)>& work, const std::function<void(double)>& tell) {
  std::atomic<std::int32_t> next{0};
  std::mutex mutex;
  std::condition_variable changed;
  int busy = std::min(kThreads, n);
  std::vector<std::thread> threads;
  for (int t = 0; t < std::min(kThreads, n); ++t) {
    threads.emplace_back([&] {
      for (std::int32_t i = next++; i < n && work(i); i = next++) {
      }
      const std::lock_guard lock(mutex);
      --busy;
      changed.notify_one();
    });
  }
  std::unique_lock lock(mutex);
  do {
    tell(n == 0 ? 1.0 : static_cast<double>(std::min<std::int32_t>(next, n)) / n);
  } while (!changed.wait_for(lock, kTellEvery, [&] { return busy == 0; }));
  lock.unlock();
  for (std::thread& thread : threads) thread.join();
}

v1::Scene scene_of(const Plan& plan) {
  v1::Scene scene;
  scene.mutable_grid()->set_columns(plan.columns);
  scene.mutable_grid()->set_rows(plan.rows);
  scene.mutable_grid()->set_width_m(length_m(plan.columns));
  scene.mutable_grid()->set_height_m(length_m(plan.rows));
  scene.set_tick_rate_hz(plan.tick_rate_hz);
  if (plan.still) {
    scene.mutable_gravity_mps2();
    return scene;
  }
  v1::Constraint& corners = *scene.add_constraints();
  corners.mutable_region()->set_edge(v1::Region::TOP_CORNERS);
  corners.mutable_displacement_m()->set_y(kSwing_m);
  const double end = plan.warm_up_s + plan.duration_s + kSpare_s;
  for (int k = 0; k * kHalfSwing_s <= end; ++k) {
    corners.mutable_history()->add_times(k * kHalfSwing_s);
    corners.mutable_history()->add_factors(k == 0 ? 0.0 : (k % 2 == 0 ? -1.0 : 1.0));
  }
  return scene;
}

}  // namespace

SheetSet::SheetSet(const Plan& plan, client::Client& client, Waiter& waiter, Tell tell)
    : plan_(plan), client_(client), tell_(std::move(tell)) {
  v1::CreateSheetRequest request;
  *request.mutable_scene() = scene_of(plan);
  request.set_paused(plan.staged == Staged::kSheets);
  const auto make = [&](std::int32_t i) {
    v1::CreateSheetRequest named = request;
    named.set_sheet_id(plan_.prefix + "-" + std::to_string(i));
    const Nanoseconds until = waiter.now() + kPatience;
    while (waiter.wait_until(waiter.now())) {
      v1::Sheet sheet;
      const grpc::Status status = client_.call(&v1::SheetService::Stub::CreateSheet, client_.sheets(), named, sheet);
      const bool again = plan_.still && !status.ok() && client::reason_of(status) == "OVERLOADED";
      if (!again || waiter.now() >= until) return take(status, sheet);
      waiter.wait_until(waiter.now() + kRetryAfter);
    }
    return false;
  };
  share_out(plan.sheets, make, [this](double share) { tell_("creating sheets", share); });
  std::sort(names_.begin(), names_.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;  // Puts load-2 before load-10.
  });
}

bool SheetSet::take(const grpc::Status& status, const v1::Sheet& sheet) {
  const std::lock_guard lock(mutex_);
  if (status.ok()) {
    if (names_.empty()) integrator_ = sheet.integrator();
    names_.push_back(sheet.name());
    return !full_ && failure_.ok();
  }
  if (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) {
    if (refusals_.empty()) first_refusal_ = client::failure_of(status).message;
    ++refusals_[client::reason_of(status)];
    full_ = true;
  } else if (failure_.ok()) {
    failure_ = status;
  }
  return false;
}

SheetSet::~SheetSet() {
  const auto remove = [&](std::int32_t i) {
    v1::DeleteSheetRequest request;
    request.set_name(names_[static_cast<std::size_t>(i)]);
    google::protobuf::Empty nothing;
    // Stops deleting when a call finds the server gone, because its sheets are then gone too.
    const grpc::Status status = client_.call(&v1::SheetService::Stub::DeleteSheet, client_.sheets(), request, nothing);
    return status.error_code() != grpc::StatusCode::UNAVAILABLE;
  };
  share_out(static_cast<std::int32_t>(names_.size()), remove,
            [this](double share) { tell_("deleting sheets", share); });
}

}  // namespace kerf::load
