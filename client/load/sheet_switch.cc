#include "client/load/sheet_switch.h"

#include <algorithm>

#include "client/cpp/failure.h"

namespace kerf::load {

SheetSwitch::SheetSwitch(const std::vector<std::string>& sheets, std::int32_t running, client::Client& client,
                         Recorder& recorder)
    : sheets_(sheets), client_(client), recorder_(recorder), count_(running), runs_(sheets.size()) {}

void SheetSwitch::set(std::int32_t count) {
  count = std::clamp(count, 0, static_cast<std::int32_t>(sheets_.size()));
  const auto refused = [this](const char* call, const grpc::Status& status) {
    if (!status.ok()) recorder_.error(call + client::reason_of(status));
  };
  v1::Sheet sheet;
  while (count_ < count) {
    const auto i = static_cast<std::size_t>(count_.load());
    v1::ResumeSheetRequest request;
    request.set_name(sheets_[i]);
    refused("ResumeSheet ", client_.call(&v1::SheetService::Stub::ResumeSheet, client_.sheets(), request, sheet));
    runs_[i].since = now();
    ++count_;
  }
  while (count_ > count) {
    --count_;
    const auto i = static_cast<std::size_t>(count_.load());
    v1::PauseSheetRequest request;
    request.set_name(sheets_[i]);
    refused("PauseSheet ", client_.call(&v1::SheetService::Stub::PauseSheet, client_.sheets(), request, sheet));
    if (runs_[i].since) runs_[i].before += now() - *runs_[i].since;
    runs_[i].since.reset();
  }
}

double SheetSwitch::ran_s(std::size_t sheet, Nanoseconds until) const {
  const Run& run = runs_[sheet];
  return 1e-9 * static_cast<double>((run.before + (run.since ? until - *run.since : Nanoseconds(0))).count());
}

}  // namespace kerf::load
