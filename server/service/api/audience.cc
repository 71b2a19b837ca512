#include "server/service/api/audience.h"

#include <algorithm>
#include <utility>

namespace kerf::api {
Audience::Wakes Audience::begin_turn(OfSheet& sheet) {
  ++sheet.num_turns;
  sheet.last_turn = clock_.now();
  Wakes found;
  for (const auto& [number, member] : sheet.members) {
    if (member.wake) found.push_back(member.wake);
  }
  return found;
}

Audience::Wakes Audience::changed(const std::string& name, OfSheet& sheet) {
  if (sheet.num_turns == 0 || clock_.now() >= sheet.last_turn + kTurn) return begin_turn(sheet);
  if (!std::exchange(sheet.is_turn_planned, true)) {
    clock_.schedule(sheet.last_turn + kTurn, [weak = weak_from_this(), name] {
      if (const auto self = weak.lock()) self->take_planned_turn(name);
    });
  }
  return {};
}

void Audience::take_planned_turn(const std::string& sheet) {
  Wakes wakes;
  {
    const std::lock_guard lock(mutex_);
    const auto found = sheets_.find(sheet);
    if (found == sheets_.end()) return;
    found->second.is_turn_planned = false;
    wakes = begin_turn(found->second);
  }
  for (const auto& wake : wakes) wake();
}

std::size_t Audience::num_pointing(const OfSheet& sheet) {
  const auto points = [](const auto& each) { return each.second.pointer.has_value(); };
  return static_cast<std::size_t>(std::count_if(sheet.members.begin(), sheet.members.end(), points));
}

void Audience::remove_unused(const std::string& sheet) {
  const auto found = sheets_.find(sheet);
  if (found != sheets_.end() && found->second.members.empty() && found->second.activities.empty()) sheets_.erase(found);
}

std::shared_ptr<Audience::Seat> Audience::join(const std::string& sheet, const auth::Caller& caller, bool pictures,
                                               std::function<void()> wake) {
  Wakes wakes;
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
    of_sheet.members.emplace(number, Member{std::move(viewer), std::move(wake), {}, 0});
    of_sheet.members_version = ++last_version_;
    wakes = changed(sheet, of_sheet);
  }
  for (const auto& each : wakes) each();
  return std::make_shared<Seat>(shared_from_this(), sheet, number);
}

void Audience::leave(const std::string& sheet, std::int32_t number) {
  Wakes wakes;
  {
    const std::lock_guard lock(mutex_);
    OfSheet& of_sheet = sheets_[sheet];
    of_sheet.members.erase(number);
    of_sheet.members_version = ++last_version_;
    if (!of_sheet.members.empty()) wakes = changed(sheet, of_sheet);
    remove_unused(sheet);
  }
  for (const auto& wake : wakes) wake();
}

void Audience::add(const std::string& sheet, const auth::Caller& caller, const std::string& call) {
  Wakes wakes;
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
    if (!of_sheet.members.empty()) wakes = changed(sheet, of_sheet);
  }
  for (const auto& wake : wakes) wake();
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
  if (turn_seen_ == of_sheet.num_turns) return std::nullopt;
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
  if (next == nullptr) {
    turn_seen_ = of_sheet.num_turns;
    return std::nullopt;
  }
  pointers_seen_ = next->pointer_version;
  response.mutable_pointer()->set_viewer(next->viewer.number());
  if (next->pointer) *response.mutable_pointer()->mutable_material() = *next->pointer;
  return response;
}

void Audience::Seat::point(const v1::Pointer& pointer) {
  Wakes wakes;
  {
    const std::lock_guard lock(audience_->mutex_);
    OfSheet& of_sheet = audience_->sheets_[sheet_];
    const auto self = of_sheet.members.find(number_);
    if (self == of_sheet.members.end()) return;
    Member& member = self->second;
    const bool ends = !pointer.has_material();
    if (ends && !member.pointer) return;
    if (!ends && !member.pointer && num_pointing(of_sheet) >= kMaxPointing) return;
    member.pointer = ends ? std::nullopt : std::optional(pointer.material());
    member.pointer_version = ++audience_->last_version_;
    wakes = audience_->changed(sheet_, of_sheet);
  }
  for (const auto& wake : wakes) wake();
}

}  // namespace kerf::api
