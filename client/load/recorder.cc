#include "client/load/recorder.h"

#include <algorithm>

namespace kerf::load {

const char* name_of(Role role) {
  switch (role) {
    case Role::kViewer:
      return "viewers";
    case Role::kSlow:
      return "slow readers";
    case Role::kStalled:
      return "stalled readers";
    case Role::kImage:
      return "image viewers";
  }
  return "";
}

void Stretch::merge(const Stretch& other) {
  frames += other.frames;
  bytes += other.bytes;
  age_us.merge(other.age_us);
  cut_us.merge(other.cut_us);
  errors += other.errors;
}

void Recorder::measure(Nanoseconds begin, Nanoseconds end) {
  end_ = end;
  begin_ = begin;  // Written last, so that counts() never sees a begin without its end.
}

Stretch& Recorder::stretch_at(Nanoseconds time) {
  const Nanoseconds begin = begin_;
  const double share = static_cast<double>((time - begin).count()) / static_cast<double>((end() - begin).count());
  return stretches_[std::min(static_cast<std::size_t>(share * kStretches), kStretches - 1)];
}

void Recorder::joined(Role role, Nanoseconds took) {
  const std::lock_guard lock(mutex_);
  ++of(role).readers;
  of(role).join_us.add(microseconds(took));
}

void Recorder::frame(Role role, const FrameSeen& frame) {
  if (!counts(frame.decoded)) return;
  const std::lock_guard lock(mutex_);
  ReaderTotals& totals = of(role);
  ++totals.frames;
  totals.keyframes += frame.keyframe ? 1 : 0;
  totals.bytes += frame.bytes;
  totals.skipped += frame.skipped;
  totals.age_us.add(frame.age_us);
  if (role != Role::kViewer) return;
  Stretch& stretch = stretch_at(frame.decoded);
  ++stretch.frames;
  stretch.bytes += frame.bytes;
  stretch.age_us.add(frame.age_us);
}

void Recorder::shown(Role role, std::int64_t age_us) {
  const std::lock_guard lock(mutex_);
  of(role).shown_us.add(age_us);
}

void Recorder::ended(Role role, const std::string& how, bool joined) {
  const std::lock_guard lock(mutex_);
  ++of(role).ends[how];
  of(role).ended_without += joined ? 0 : 1;
}

void Recorder::error(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  ++errors_[reason];
  const Nanoseconds time = now();
  if (counts(time)) ++stretch_at(time).errors;
}

void Recorder::answered(Nanoseconds intended, std::int64_t took_us) {
  const std::lock_guard lock(mutex_);
  cuts_.reply_us.add(took_us);
  if (counts(intended)) stretch_at(intended).cut_us.add(took_us);
}

ReaderTotals Recorder::readers(Role role) const {
  const std::lock_guard lock(mutex_);
  return readers_[static_cast<std::size_t>(role)];
}

CutTotals Recorder::cut_totals() const {
  const std::lock_guard lock(mutex_);
  return cuts_;
}

std::vector<Stretch> Recorder::stretches() const {
  const std::lock_guard lock(mutex_);
  return stretches_;
}

std::map<std::string, std::int64_t> Recorder::errors() const {
  const std::lock_guard lock(mutex_);
  return errors_;
}

}  // namespace kerf::load
