#include "server/service/api/audience.h"

#include <algorithm>
#include <utility>

namespace kerf::api {
std::vector<std::function<void()>> Audience::wakes(const OfSheet& sheet, std::int32_t but) {
  std::vector<std::function<void()>> found;
  for (const auto& [number, member] : sheet.members) {
    if (number != but && member.wake) found.push_back(member.wake);
  }
  return found;
}

void Audience::remove_unused(const std::string& sheet) {
  const auto found = sheets_.find(sheet);
  if (found != sheets_.end() && found->second.members.empty() && found->second.activities.empty()) sheets_.erase(found);
}

std::shared_ptr<Audience::Seat> Audience::join(const std::string& sheet, const auth::Caller& caller, bool pictures,
                                               std::function<void()> wake) {
  std::vector<std::function<void()>> others;
  std::int32_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    OfSheet& of_sheet = sheets_[sheet];
    number = ++num_joined_;
    v1::Viewer viewer;
    viewer.set_number(number);
    viewer.set_token_id(caller->token_id());
    viewer.set_scope(static_cast<v1::Scope>(caller->rights().scope));  // They have the same numbers.
    viewer.set_by_link(caller->is_by_link());
    viewer.set_pictures(pictures);
    of_sheet.members.emplace(number, Member{std::move(viewer),
                                            std::move(wake),
                                            {},
                                            0,
                                            TokenBucket(kPointersPerSecond, kPointersPerSecond, clock_.now())});
    of_sheet.members_version = ++last_version_;
    others = wakes(of_sheet, 0);
  }
  for (const auto& call : others) call();
  return std::make_shared<Seat>(shared_from_this(), sheet, number);
}

void Audience::leave(const std::string& sheet, std::int32_t number) {
  std::vector<std::function<void()>> others;
  {
    const std::lock_guard lock(mutex_);
    OfSheet& of_sheet = sheets_[sheet];
    of_sheet.members.erase(number);
    of_sheet.members_version = ++last_version_;
    others = wakes(of_sheet, number);
    remove_unused(sheet);
  }
  for (const auto& call : others) call();
}

void Audience::add(const std::string& sheet, const auth::Caller& caller, const std::string& call) {
  std::vector<std::function<void()>> viewers;
  {
    const std::lock_guard lock(mutex_);
    OfSheet& of_sheet = sheets_[sheet];
    v1::Activity activity;
    activity.set_token_id(caller->token_id());
    activity.set_by_link(caller->is_by_link());
    activity.set_call(call);
    activity.set_unix_us(clock_.unix_us());
    of_sheet.activities.push_back(std::move(activity));
    if (of_sheet.activities.size() > kMaxActivities) of_sheet.activities.pop_front();
    ++of_sheet.num_activities;
    viewers = wakes(of_sheet, 0);
  }
  for (const auto& wake : viewers) wake();
}

void Audience::forget(const std::string& sheet) {
  const std::lock_guard lock(mutex_);
  const auto found = sheets_.find(sheet);
  if (found == sheets_.end()) return;
  found->second.activities.clear();
  remove_unused(sheet);
}

std::optional<v1::WatchResponse> Audience::Seat::next() {
  const std::lock_guard lock(audience_->mutex_);
  const OfSheet& of_sheet = audience_->sheets_[sheet_];
  v1::WatchResponse response;
  if (members_seen_ < of_sheet.members_version) {
    members_seen_ = of_sheet.members_version;
    v1::Audience& audience = *response.mutable_audience();
    audience.set_own_number(number_);
    audience.set_num_viewers(static_cast<std::int32_t>(of_sheet.members.size()));
    for (const auto& [number, member] : of_sheet.members) {
      if (audience.viewers().size() == static_cast<int>(kMaxListedViewers)) break;
      *audience.add_viewers() = member.viewer;
    }
    return response;
  }
  const auto kept = static_cast<std::int64_t>(of_sheet.activities.size());
  activities_seen_ = std::max(activities_seen_, of_sheet.num_activities - kept);
  if (activities_seen_ < of_sheet.num_activities) {
    const std::int64_t at = kept - (of_sheet.num_activities - activities_seen_);
    *response.mutable_activity() = of_sheet.activities[static_cast<std::size_t>(at)];
    ++activities_seen_;
    return response;
  }
  const Member* next = nullptr;  // the one that moved first of those not seen yet
  for (const auto& [number, member] : of_sheet.members) {
    if (number == number_ || member.pointer_version <= pointers_seen_) continue;
    if (next == nullptr || member.pointer_version < next->pointer_version) next = &member;
  }
  if (next == nullptr) return std::nullopt;
  pointers_seen_ = next->pointer_version;
  response.mutable_pointer()->set_viewer(next->viewer.number());
  if (next->pointer) *response.mutable_pointer()->mutable_material() = *next->pointer;
  return response;
}

void Audience::Seat::point(const v1::Pointer& pointer) {
  std::vector<std::function<void()>> others;
  {
    const std::lock_guard lock(audience_->mutex_);
    OfSheet& of_sheet = audience_->sheets_[sheet_];
    const auto self = of_sheet.members.find(number_);
    if (self == of_sheet.members.end()) return;
    Member& member = self->second;
    const bool ends = !pointer.has_material();
    if (ends ? !member.pointer : !member.pointers.take(1.0, audience_->clock_.now())) return;
    member.pointer = ends ? std::nullopt : std::optional(pointer.material());
    member.pointer_version = ++audience_->last_version_;
    others = wakes(of_sheet, number_);
  }
  for (const auto& wake : others) wake();
}

}  // namespace kerf::api
