#include "tests/store/power_model.h"

#include <algorithm>
#include <utility>

namespace kerf::test {
namespace {

std::string random_bytes(SeededRandom& random, std::uint64_t most) {
  std::string bytes(1 + random.below(most), '\0');
  for (char& byte : bytes) byte = static_cast<char>(random.next());
  return bytes;
}

bool is_same(const host::JournalEntry& a, const host::JournalEntry& b) {
  return a.sheet == b.sheet && a.seq == b.seq && a.tick == b.tick && a.state_hash == b.state_hash &&
         a.content == b.content;
}

bool is_same(const host::StoredState& a, const host::StoredState& b) {
  return a.tick == b.tick && a.engine == b.engine && a.state_hash == b.state_hash &&
         a.continuation_hash == b.continuation_hash && a.content == b.content;
}

std::string at(std::int64_t sheet, std::int64_t seq) {
  return "entry " + std::to_string(seq) + " of sheet " + std::to_string(sheet);
}

}  // namespace

std::vector<host::StoredRequest> PowerModel::requests(SeededRandom& random, std::int64_t sheet, std::int64_t seq) {
  std::vector<host::StoredRequest> made(random.below(3));
  for (host::StoredRequest& one : made) {
    one.key = "Cut " + std::to_string(random.below(1000)) + "-" + std::to_string(++num_requests_);
    one.body_hash = random.next();
    one.reply = random_bytes(random, 200);
    requests_[one.key] = {one.reply, sheet, seq, false};
  }
  return made;
}

// The callback runs while the thread that gives changes waits, so it needs no lock.
std::function<void()> PowerModel::answered(std::vector<host::StoredRequest> requests,
                                           std::function<void(PowerModel&)> note, std::function<void()> then) {
  return [this, requests = std::move(requests), note = std::move(note), then = std::move(then)] {
    for (const host::StoredRequest& one : requests) requests_[one.key].is_answered = true;
    note(*this);
    ++num_answered_;
    if (then) then();
  };
}

void PowerModel::give_change(store::SqliteStore& store, SeededRandom& random, std::function<void()> then) {
  std::vector<std::int64_t> live;
  for (const auto& [number, sheet] : sheets_) {
    if (!sheet.is_removal_given) live.push_back(number);
  }
  if (live.empty() || (live.size() < 3 && random.below(8) == 0)) {
    const std::int64_t number = store.new_sheet_number();
    if (sheets_.count(number) > 0) add_loss("sheet number " + std::to_string(number) + " was given twice");
    Sheet& sheet = sheets_[number];
    sheet.scene = random_bytes(random, 3000);
    auto with = requests(random, number, 0);
    store.create({number, "s" + std::to_string(number), sheet.scene, 1, with},
                 answered(
                     with, [number](PowerModel& self) { self.sheets_[number].is_created = true; }, std::move(then)));
    return;
  }
  const std::int64_t number = live[random.below(live.size())];
  switch (random.below(20)) {
    case 0: {
      sheets_[number].is_removal_given = true;
      auto with = requests(random, number, 0);
      store.remove(number, with,
                   answered(
                       with, [number](PowerModel& self) { self.sheets_[number].is_removed = true; }, std::move(then)));
      return;
    }
    case 1:
    case 2:
    case 3:
    case 4:
      save(store, random, number, nullptr);
      break;
    case 5:
    case 6: {
      Sheet& sheet = sheets_[number];
      sheet.highest_mark += static_cast<std::int64_t>(random.below(50));
      store.mark({{number, sheet.highest_mark}});
      break;
    }
    default:
      break;
  }
  append(store, random, number, std::move(then));
}

void PowerModel::append(store::SqliteStore& store, SeededRandom& random, std::int64_t number,
                        std::function<void()> then) {
  Sheet& sheet = sheets_[number];
  host::JournalEntry entry;
  entry.sheet = number;
  entry.seq = static_cast<std::int64_t>(sheet.entries.size()) + 1;
  entry.tick = sheet.highest_mark + entry.seq;
  entry.state_hash = random.next();
  entry.content = random_bytes(random, random.below(10) == 0 ? 9000 : 300);
  sheet.entries.push_back(entry);
  auto with = requests(random, number, entry.seq);
  entry.requests = with;
  const std::int64_t seq = entry.seq;
  store.append(std::move(entry), answered(
                                     with,
                                     [=](PowerModel& self) {
                                       Sheet& own = self.sheets_[number];
                                       if (own.num_answered + 1 != seq)
                                         self.add_loss(at(number, seq) + " out of order");
                                       own.num_answered = seq;
                                     },
                                     std::move(then)));
}

void PowerModel::save(store::SqliteStore& store, SeededRandom& random, std::int64_t number,
                      std::function<void()> then) {
  Sheet& sheet = sheets_[number];
  host::StoredState state;
  state.sheet = number;
  state.seq = static_cast<std::int64_t>(sheet.entries.size());
  state.tick = sheet.highest_mark + state.seq;
  state.engine = random.next();
  state.state_hash = random.next();
  state.continuation_hash = random.next();
  if (random.below(4) == 0) state.name = "name " + std::to_string(random.below(2));
  state.content = random_bytes(random, random.below(400) == 0 ? 2'200'000 : 2500);
  const std::size_t index = sheet.states.size();
  sheet.states.push_back({state, false});
  store.save(std::move(state), answered(
                                   {}, [=](PowerModel& self) { self.sheets_[number].states[index].is_answered = true; },
                                   std::move(then)));
}

void PowerModel::compare(store::SqliteStore& store) {
  const auto sheets = store.sheets();
  if (!sheets.ok()) return add_loss(sheets.error().message);
  std::map<std::int64_t, store::StoredSheet> found;
  for (const store::StoredSheet& sheet : *sheets) {
    found[sheet.sheet] = sheet;
    if (sheets_.count(sheet.sheet) == 0) {
      add_loss("sheet " + std::to_string(sheet.sheet) + " was never given");
    } else {
      compare_sheet(store, sheet);
    }
  }
  for (const auto& [number, sheet] : sheets_) {
    const bool is_expected = (sheet.is_created || sheet.num_answered > 0) && !sheet.is_removal_given;
    if (is_expected && found.count(number) == 0) add_loss("sheet " + std::to_string(number) + " is lost");
  }
  compare_requests(store, found);
  take_over(found);
}

// A sheet that is gone stays gone: no change of it is given any more. One that never was may leave its number to
// another.
void PowerModel::take_over(const std::map<std::int64_t, store::StoredSheet>& found) {
  for (auto known = sheets_.begin(); known != sheets_.end();) {
    auto& [number, sheet] = *known;
    const bool is_there = found.count(number) > 0;
    const bool never_was = !is_there && !sheet.is_created;
    sheet.is_removal_given = sheet.is_removed = !is_there;
    if (is_there) {
      sheet.is_created = true;
      sheet.entries.resize(static_cast<std::size_t>(found.at(number).last_seq));
      sheet.num_answered = found.at(number).last_seq;
    }
    known = never_was ? sheets_.erase(known) : std::next(known);
  }
}

void PowerModel::compare_sheet(store::SqliteStore& store, const store::StoredSheet& found) {
  const Sheet& given = sheets_[found.sheet];
  const std::string name = "sheet " + std::to_string(found.sheet);
  if (given.is_removed) add_loss(name + " was removed, and is there");
  if (found.is_damaged || found.scene != given.scene) add_loss(name + " has changed");
  if (found.last_seq < given.num_answered) {
    add_loss(name + " ends with entry " + std::to_string(found.last_seq) + ", " + std::to_string(given.num_answered) +
             " were answered");
  }
  if (found.last_seq > static_cast<std::int64_t>(given.entries.size()))
    return add_loss(name + " has entries never given");
  if (found.mark && *found.mark > given.highest_mark) add_loss(name + " has a mark never given");
  const auto entries = store.entries(found.sheet, std::max<std::int64_t>(found.first_seq, 1) - 1);
  if (!entries.ok()) return add_loss(entries.error().message);
  for (const host::JournalEntry& entry : *entries) {
    if (!is_same(entry, given.entries[static_cast<std::size_t>(entry.seq - 1)])) {
      add_loss(at(entry.sheet, entry.seq) + " has changed");
    }
  }
  compare_states(store, found);
}

// Each state that is there is readable and one of those given. Those that were answered last, of each name, are there
// or were followed by others.
void PowerModel::compare_states(store::SqliteStore& store, const store::StoredSheet& found) {
  std::vector<GivenState>& given = sheets_[found.sheet].states;
  std::map<std::string, std::size_t> newest;  // index among those given of the newest that is there, by name
  for (const store::StateInfo& info : found.states) {
    const auto read = store.read_state(info.sheet, info.seq, info.name);
    if (!read.ok()) {
      add_loss(read.error().message);
      continue;
    }
    const auto match = std::find_if(given.begin(), given.end(), [&](const GivenState& one) {
      return one.state.seq == info.seq && one.state.name == info.name && is_same(one.state, *read);
    });
    if (match == given.end()) {
      add_loss("a state of sheet " + std::to_string(found.sheet) + " was never given");
      continue;
    }
    const auto index = static_cast<std::size_t>(match - given.begin());
    const auto [known, is_first] = newest.emplace(info.name, index);
    if (!is_first) known->second = std::max(known->second, index);
  }
  std::vector<GivenState> kept;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const auto known = newest.find(given[i].state.name);
    const bool is_there_or_followed = known != newest.end() && known->second >= i;
    if (given[i].is_answered && !is_there_or_followed) {
      add_loss("a state of sheet " + std::to_string(found.sheet) + " is lost");
    }
    if (is_there_or_followed) kept.push_back({given[i].state, true});
  }
  given = std::move(kept);
}

void PowerModel::compare_requests(store::SqliteStore& store, const std::map<std::int64_t, store::StoredSheet>& found) {
  const auto kept = store.requests(1'000'000, std::size_t{1} << 40U);
  if (!kept.ok()) return add_loss(kept.error().message);
  if (kept->num_damaged > 0) add_loss("an answer has changed");
  std::map<std::string, store::KeptRequest> by_key;
  for (const store::KeptRequest& one : kept->requests) {
    if (!by_key.emplace(one.request.key, one).second) add_loss("request " + one.request.key + " is there twice");
  }
  for (auto known = requests_.begin(); known != requests_.end();) {
    const auto stored = by_key.find(known->first);
    const bool is_there = stored != by_key.end();
    const Request& given = known->second;
    if (given.is_answered && !is_there) add_loss("request " + known->first + " is lost");
    if (is_there && stored->second.request.reply != given.reply)
      add_loss("the answer of " + known->first + " has changed");
    const auto sheet = found.find(given.sheet);
    const bool is_entry_there = sheet != found.end() && sheet->second.last_seq >= given.seq;
    if (is_entry_there && given.seq > 0 && !is_there)
      add_loss("request " + known->first + " is lost, its entry is there");
    if (is_there && sheet != found.end() && given.seq > sheet->second.last_seq) {
      add_loss("request " + known->first + " is there, its entry is lost");
    }
    if (is_there) by_key.erase(stored);
    known->second.is_answered = is_there;
    known = is_there ? std::next(known) : requests_.erase(known);
  }
  if (!by_key.empty()) add_loss("request " + by_key.begin()->first + " was never given");
}

}  // namespace kerf::test
