#include "server/service/host/step_group.h"

#include <string>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/service/host/sheet_runner.h"

namespace kerf::host {

StepGroup::StepGroup(std::vector<std::shared_ptr<SheetRunner>> runners, std::int64_t ticks,
                     std::shared_ptr<StepVisitor> visitor, Callback<Nothing> done, std::stop_token stop)
    : runners_(std::move(runners)),
      ticks_(ticks),
      visitor_(std::move(visitor)),
      done_(std::move(done)),
      stop_(std::move(stop)),
      entries_(runners_.size()),
      to_check_(runners_.size()),
      to_end_(runners_.size()) {}

void StepGroup::begin() {
  for (std::size_t number = 0; number < runners_.size(); ++number) {
    runners_[number]->post([self = shared_from_this(), number](SheetRunner& runner) { self->reserve(number, runner); },
                           [self = shared_from_this(), number](Error error) {
                             self->entries_[number].check = std::move(error);
                             self->checked(nullptr);
                           });
  }
}

void StepGroup::reserve(std::size_t number, SheetRunner& runner) {
  Entry& entry = entries_[number];
  entry.check = runner.reserve_step(
      this,
      [self = shared_from_this(), number](SheetRunner& r, const Status& status) { self->ended(number, r, status); },
      stop_);
  if (entry.check.ok()) {
    entry.is_reserved = true;
    entry.check = catch_exceptions([&] { return visitor_->check(number, runner.sheet()); });
  }
  checked(&runner);
}

// Steps the sheets after the last check, or gives them back. `here`: the sheet on whose strand this is, if any.
void StepGroup::checked(SheetRunner* here) {
  if (--to_check_ > 0) return;
  Status all = Nothing{};
  for (std::size_t number = 0; number < entries_.size() && all.ok(); ++number) {
    if (entries_[number].check.ok()) continue;
    Error error = entries_[number].check.error();
    if (error.field.empty()) error.field = "names[" + std::to_string(number) + "]";
    all = std::move(error);
  }
  if (all.ok()) all = catch_exceptions([this] { return visitor_->check_all(); });
  if (!all.ok()) {
    is_refused_ = true;
    fail(all.error());
  }
  const std::int64_t ticks = all.ok() ? ticks_ : 0;
  for (std::size_t number = 0; number < runners_.size(); ++number) {
    SheetRunner* const runner = runners_[number].get();
    if (!entries_[number].is_reserved) {
      finished();
    } else if (runner == here && runners_.size() == 1) {
      runner->run_reserved(this, ticks);
    } else {
      // A sheet that closes before this ends its call by itself.
      runner->post([self = shared_from_this(), ticks](SheetRunner& r) { r.run_reserved(self.get(), ticks); },
                   [](const Error&) {});
    }
  }
}

void StepGroup::ended(std::size_t number, SheetRunner& runner, const Status& status) {
  const bool stops = !status.ok() && status.error().code == ErrorCode::kUnavailable;
  if (stops) fail(status.error());
  if (!is_refused_ && !stops) {
    const Status seen = catch_exceptions([&]() -> Status {
      visitor_->look(number, runner.sheet(), status);
      return Nothing{};
    });
    if (!seen.ok()) fail(seen.error());
  }
  runner.answer<Nothing>(
      [self = shared_from_this(), was_whole = status.ok()](const Status& stored) {
        if (!stored.ok() && was_whole) self->fail(stored.error());
        self->finished();
      },
      Nothing{});
}

void StepGroup::fail(const Error& error) {
  const std::lock_guard lock(mutex_);
  if (!failure_) failure_ = error;
}

void StepGroup::finished() {
  if (--to_end_ > 0) return;
  std::optional<Error> failure;
  {
    const std::lock_guard lock(mutex_);
    failure = failure_;
  }
  if (failure) return done_(*failure);
  done_(Nothing{});
}

}  // namespace kerf::host
