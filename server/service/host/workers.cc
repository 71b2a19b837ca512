#include "server/service/host/workers.h"

#include <algorithm>
#include <condition_variable>
#include <list>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "server/base/check.h"
#include "server/base/thread_priority.h"
#include "server/service/host/fair_queue.h"

namespace kerf::host {

// Lists, because most strands are idle and an empty list has no heap memory.
using Pieces = std::list<std::function<void()>>;

// Guarded by Pool::mutex.
struct Workers::Order {
  std::shared_ptr<FairQueue<std::shared_ptr<Order>>::Group> group;
  Pieces waiting;
  bool has_turn = false;  // In Pool::ready, or run by a thread.
};

struct Workers::Pool {
  using SteadyClock = std::chrono::steady_clock;
  using Lock = std::unique_lock<std::mutex>;

  struct Thread {
    std::thread thread;
    std::optional<SteadyClock::time_point> busy_since;  // Start of the present piece of work.
    bool replaced = false;                              // The thread ends after its present piece of work.
  };
  using Threads = std::list<Thread>;

  explicit Pool(const Options& wanted) : options(wanted) {}

  bool post(const std::shared_ptr<Order>& order, std::function<void()> work);
  void add_thread();
  void join();

  // These run on the threads.
  void run(Threads::iterator self);
  void take_turn(const std::shared_ptr<Order>& order, Thread& self, Lock& lock);
  // These run on the supervisor.
  void supervise();
  void join_retired(Lock& lock);
  bool take_on(Thread& late);

  // True if more strands are ready than threads are idle. An idle thread counts until it has taken its work.
  [[nodiscard]] bool lacks_threads() const { return ready.size() > num_idle && num_replaced < options.max_taken_on; }
  struct Wakes {
    bool thread = false;
    bool supervisor = false;
  };
  // Returns the threads to wake for a strand that has become ready, if no running thread will take it.
  Wakes wakes_for_ready();
  void wake(Wakes wakes);

  const Options options;
  // Guards everything below except `supervisor`.
  mutable std::mutex mutex;
  std::condition_variable idle;             // Signals that nothing is outstanding.
  std::condition_variable work_waits;       // For the threads.
  std::condition_variable attention;        // For the supervisor: threads may be lacking, or one has retired.
  FairQueue<std::shared_ptr<Order>> ready;  // Waiting for their turn.
  std::int64_t outstanding = 0;             // Pieces posted and not finished.
  std::size_t num_idle = 0;                 // Idle threads.
  std::size_t num_replaced = 0;             // Replaced threads in `threads`.
  bool supervisor_sleeps = false;  // True if the supervisor sleeps until it is notified; false if it wakes by itself.
  bool closed = false;             // True once join() saw nothing outstanding: posts are refused and threads end.
  Threads threads;
  Threads retired;  // Have left run(), or are about to; to be joined.
  std::thread supervisor;
};

bool Workers::Pool::post(const std::shared_ptr<Order>& order, std::function<void()> work) {
  Pieces piece;  // Made without the mutex; also destroyed without it if refused.
  piece.push_back(std::move(work));
  Lock lock(mutex);
  if (closed) return false;
  ++outstanding;
  order->waiting.splice(order->waiting.end(), piece);
  if (order->has_turn) return true;
  order->has_turn = true;
  ready.push(order->group, order);
  const Wakes wakes = wakes_for_ready();
  lock.unlock();  // A woken thread would only wait for it.
  wake(wakes);
  return true;
}

Workers::Pool::Wakes Workers::Pool::wakes_for_ready() {
  const bool alert = supervisor_sleeps && lacks_threads();
  if (alert) supervisor_sleeps = false;  // Waking it once is enough.
  return {num_idle > 0, alert};
}

void Workers::Pool::wake(Wakes wakes) {
  if (wakes.thread) work_waits.notify_one();
  if (wakes.supervisor) attention.notify_one();
}

// Needs the mutex held, so that the thread is counted before it looks for work. Throws if the system has no thread.
void Workers::Pool::add_thread() {
  Threads made(1);
  made.front().thread = std::thread([this, self = made.begin()] { run(self); });
  threads.splice(threads.end(), made);
  ++num_idle;
}

void Workers::Pool::run(Threads::iterator self) {
  if (options.is_background) lower_thread_priority();
  Lock lock(mutex);
  while (true) {
    work_waits.wait(lock, [&] { return closed || !ready.empty(); });
    if (ready.empty()) return;
    --num_idle;
    const std::shared_ptr<Order> order = ready.pop();
    take_turn(order, *self, lock);
    if (self->replaced) break;
    ++num_idle;
  }
  // Within the critical section that finished its last piece, so that join() always sees it on one of the lists.
  --num_replaced;
  retired.splice(retired.end(), threads, self);
  attention.notify_one();
}

// Runs the pieces that wait now. Those posted during the turn wait for the next one, behind the other strands.
void Workers::Pool::take_turn(const std::shared_ptr<Order>& order, Thread& self, Lock& lock) {
  for (std::size_t left = order->waiting.size(); left > 0 && !self.replaced; --left) {
    Pieces piece;
    piece.splice(piece.end(), order->waiting, order->waiting.begin());
    self.busy_since = SteadyClock::now();
    lock.unlock();
    piece.front()();
    piece.clear();  // Destroys the captured objects before the pool may count as idle.
    const Nanoseconds used = SteadyClock::now() - *self.busy_since;
    lock.lock();
    ready.charge(*order->group, used);
    if (--outstanding == 0) idle.notify_all();
  }
  self.busy_since.reset();
  order->has_turn = !order->waiting.empty();
  if (!order->has_turn) return;
  ready.push(order->group, order);
  if (self.replaced) wake(wakes_for_ready());  // Otherwise this thread takes the next ready strand itself.
}

// Adds threads when they are lacking, and sleeps otherwise. While threads are lacking, it waits until the longest piece
// in progress has taken `long_work`. If all pieces are short, it wakes once per `long_work`.
void Workers::Pool::supervise() {
  constexpr Nanoseconds kLongestSleep = std::chrono::hours(1);  // Keeps deadlines from overflowing.
  const Nanoseconds long_work = options.long_work;
  Lock lock(mutex);
  while (!closed) {
    if (!retired.empty()) {
      join_retired(lock);
      continue;
    }
    if (!lacks_threads()) {
      supervisor_sleeps = true;
      attention.wait(lock);
      supervisor_sleeps = false;
      continue;
    }
    const SteadyClock::time_point now = SteadyClock::now();
    Thread* longest = nullptr;
    for (Thread& thread : threads) {
      if (thread.replaced || !thread.busy_since) continue;
      if (longest == nullptr || thread.busy_since < longest->busy_since) longest = &thread;
    }
    const Nanoseconds at_it = longest == nullptr ? Nanoseconds(0) : Nanoseconds(now - *longest->busy_since);
    if (at_it < long_work) {
      attention.wait_for(lock, std::min(long_work - at_it, kLongestSleep));
    } else if (!take_on(*longest)) {
      attention.wait_for(lock, std::min(long_work, kLongestSleep));  // The system may have a thread by then.
    }
  }
}

void Workers::Pool::join_retired(Lock& lock) {
  Threads ended;
  ended.swap(retired);
  lock.unlock();
  for (Thread& thread : ended) thread.thread.join();
  lock.lock();
}

bool Workers::Pool::take_on(Thread& late) {
  try {
    add_thread();
  } catch (const std::system_error&) {
    return false;
  }
  late.replaced = true;
  ++num_replaced;
  return true;
}

void Workers::Pool::join() {
  {
    Lock lock(mutex);
    idle.wait(lock, [&] { return outstanding == 0; });
    closed = true;
    work_waits.notify_all();
    attention.notify_all();
  }
  if (supervisor.joinable()) supervisor.join();  // From here on the lists do not change.
  for (Threads* list : {&threads, &retired}) {
    for (Thread& thread : *list) thread.thread.join();
  }
  const std::lock_guard lock(mutex);
  threads.clear();
  retired.clear();
}

Workers::Strand::Strand(std::shared_ptr<Pool> pool, std::shared_ptr<Order> order)
    : pool_(std::move(pool)), order_(std::move(order)) {}

bool Workers::Strand::post(std::function<void()> work) const {
  return pool_->post(order_, std::move(work));
}

Workers::Workers(std::shared_ptr<Pool> pool) : pool_(std::move(pool)) {}

// Delegates to the constructor above, so that after an exception here the destructor ends the threads made so far.
Workers::Workers(const Options& options) : Workers(std::make_shared<Pool>(options)) {
  KERF_CHECK(options.num_threads >= 1, "a pool without threads never finishes anything");
  KERF_CHECK(options.long_work >= Nanoseconds(0), "nothing takes less than no time");
  {
    const std::lock_guard lock(pool_->mutex);
    for (std::int32_t i = 0; i < options.num_threads; ++i) pool_->add_thread();
  }
  // Captures a raw pointer, since the pool outlives its threads; a shared one could make a worker the last owner.
  if (options.long_work > Nanoseconds(0)) pool_->supervisor = std::thread([pool = pool_.get()] { pool->supervise(); });
}

Workers::~Workers() {
  join();
}

Workers::Strand Workers::make_strand(const std::string& group) {
  const auto order = std::make_shared<Order>();
  const std::lock_guard lock(pool_->mutex);
  order->group = pool_->ready.group(group);
  return {pool_, order};
}

std::size_t Workers::num_threads() const {
  const std::lock_guard lock(pool_->mutex);
  return pool_->threads.size();
}

void Workers::wait_idle() {
  std::unique_lock lock(pool_->mutex);
  pool_->idle.wait(lock, [&] { return pool_->outstanding == 0; });
}

void Workers::join() {
  pool_->join();
}

}  // namespace kerf::host
