#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "server/base/result.h"
#include "server/service/host/command_result.h"

namespace kerf::sheet {
class Sheet;
}  // namespace kerf::sheet

namespace kerf::host {

class SheetRunner;

// Checks and sees the sheets that Host::step_all() steps. Functions with a number are called on the strand of that
// sheet, so several may run at once, each for another sheet.
class StepVisitor {
 public:
  virtual ~StepVisitor() = default;
  // Returns why the sheet must not be stepped. Called before any sheet is.
  virtual Status check(std::size_t number, const sheet::Sheet& sheet) = 0;
  // Returns why no sheet must be stepped. Called after check() of all sheets.
  virtual Status check_all() = 0;
  // Called after the sheet's last tick. `ended`: why it was stepped less far than asked for, if that is an error.
  virtual void look(std::size_t number, const sheet::Sheet& sheet, const Status& ended) = 0;
};

// Steps several sheets for one caller. It reserves all of them, so that no other call steps or resumes one, and then
// has them step side by side. It lives until the last sheet is done.
class StepGroup : public std::enable_shared_from_this<StepGroup> {
 public:
  // `done`: see Host::step_all().
  StepGroup(std::vector<std::shared_ptr<SheetRunner>> runners, std::int64_t ticks, std::shared_ptr<StepVisitor> visitor,
            Callback<Nothing> done, std::stop_token stop);

  void begin();  // To be called once.

 private:
  // Holds the state of one sheet; used on its strand, and by the last check.
  struct Entry {
    Status check = Nothing{};
    bool is_reserved = false;
  };

  void reserve(std::size_t number, SheetRunner& runner);
  void checked(SheetRunner* here);
  void ended(std::size_t number, SheetRunner& runner, const Status& status);
  void fail(const Error& error);
  void finished();

  const std::vector<std::shared_ptr<SheetRunner>> runners_;
  const std::int64_t ticks_;
  const std::shared_ptr<StepVisitor> visitor_;
  const Callback<Nothing> done_;
  const std::stop_token stop_;
  std::vector<Entry> entries_;
  std::atomic<std::size_t> to_check_;  // Sheets that were not checked yet.
  std::atomic<std::size_t> to_end_;    // Sheets whose call has not ended.
  std::atomic<bool> is_refused_{false};
  std::mutex mutex_;
  std::optional<Error> failure_;  // guarded by mutex_
};

}  // namespace kerf::host
