#include "client/load/cutter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "client/cpp/failure.h"
#include "client/load/cut_shape.h"

namespace kerf::load {
namespace {

constexpr double kLongest = 0.1;  // m, length of a cut.
constexpr double kLength = 0.3;   // Largest length, as a share of the sheet's shorter side.
constexpr double kMargin = 0.2;   // Share of each side between a cut's middle and the border: the cut stays inside.
constexpr std::chrono::seconds kPatience(60);

}  // namespace

// Holds one CreateCut in progress.
struct Cutter::Call {
  std::size_t sheet = 0;
  Nanoseconds intended{0};
  std::optional<std::int64_t> tick_when_sent;
  grpc::ClientContext context;
  v1::CreateCutRequest request;
  v1::CutResult response;
};

Cutter::Cutter(const Plan& plan, const std::vector<std::string>& sheets, const std::atomic<std::int32_t>& count,
               client::Client& client, Recorder& recorder, CutTracker& tracker, Waiter& waiter)
    : plan_(plan),
      sheets_(sheets),
      count_(count),
      client_(client),
      recorder_(recorder),
      tracker_(tracker),
      random_(plan.seed),
      thread_([this, &waiter] {
        const Schedule schedule{recorder_.begin(), Nanoseconds(std::llround(1.0e9 / plan_.cuts_per_second))};
        run_schedule(schedule, recorder_.end(), waiter,
                     [this](std::int64_t k, Nanoseconds intended) { send(k, intended); });
      }) {}

Cutter::~Cutter() {
  thread_.join();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return under_way_ == 0; });
}

bool Cutter::begin_call() {
  const std::lock_guard lock(mutex_);
  if (under_way_ >= kMostUnderWay) return false;
  ++under_way_;
  return true;
}

void Cutter::end_call() {
  const std::lock_guard lock(mutex_);
  --under_way_;
  changed_.notify_all();
}

void Cutter::send(std::int64_t k, Nanoseconds intended) {
  const double angle = random_.uniform(0.0, std::numbers::pi);
  const double width = length_m(plan_.columns);
  const double height = length_m(plan_.rows);
  const double length = std::min(kLongest, kLength * std::min(width, height));
  const double x = width * random_.uniform(kMargin, 1.0 - kMargin);
  const double y = height * random_.uniform(kMargin, 1.0 - kMargin);
  const std::int32_t count = count_;
  if (count == 0) return;
  if (!begin_call()) return recorder_.error("TOO_MANY_CUTS_UNDER_WAY");
  auto call = std::make_shared<Call>();
  call->sheet = static_cast<std::size_t>(k % count);
  call->intended = intended;
  call->tick_when_sent = tracker_.newest_tick(call->sheet);
  call->request.set_parent(sheets_[call->sheet]);
  *call->request.mutable_cut() = cut_of(plan_.cut_kind, k, {x, y, angle, length});
  call->context.set_deadline(std::chrono::system_clock::now() + kPatience);
  const std::int64_t late = microseconds(now() - intended);
  recorder_.cuts([late](CutTotals& totals) {
    ++totals.sent;
    totals.late_us.add(late);
  });
  client_.cuts().async()->CreateCut(&call->context, &call->request, &call->response,
                                    [this, call](const grpc::Status& status) {
                                      answered(*call, status);
                                      end_call();
                                    });
}

void Cutter::answered(const Call& call, const grpc::Status& status) {
  const std::int64_t took = microseconds(now() - call.intended);
  if (!status.ok()) return recorder_.error("CreateCut " + client::reason_of(status));
  const bool applied = call.response.status() == v1::CutResult::APPLIED;
  recorder_.cuts([&](CutTotals& totals) {
    ++(applied ? totals.applied : totals.missed);
    if (call.tick_when_sent) totals.reply_ticks.add(call.response.tick() - *call.tick_when_sent);
  });
  recorder_.answered(call.intended, took);
  if (!applied) return;
  tracker_.applied(call.sheet, call.response.tick(), call.response.topology_version(), call.intended);
  if (!plan_.keep_cuts) undo(call.sheet);
}

void Cutter::undo(std::size_t sheet) {
  struct Undo {
    grpc::ClientContext context;
    v1::UndoCutRequest request;
    v1::UndoResult response;
  };
  if (!begin_call()) return recorder_.error("TOO_MANY_CUTS_UNDER_WAY");
  const auto call = std::make_shared<Undo>();
  call->request.set_parent(sheets_[sheet]);
  call->context.set_deadline(std::chrono::system_clock::now() + kPatience);
  client_.cuts().async()->UndoCut(&call->context, &call->request, &call->response,
                                  [this, call](const grpc::Status& status) {
                                    if (status.ok()) {
                                      recorder_.cuts([](CutTotals& totals) { ++totals.undone; });
                                    } else {
                                      recorder_.error("UndoCut " + client::reason_of(status));
                                    }
                                    end_call();
                                  });
}

}  // namespace kerf::load
