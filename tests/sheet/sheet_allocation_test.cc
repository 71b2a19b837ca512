#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "server/sheet/sheet.h"
#include "tests/support/scenes.h"

namespace {

// Counts while a guard is on. Single-threaded test: a plain counter will do.
bool counting = false;
std::int64_t allocations = 0;

void* allocate(std::size_t size, std::size_t alignment) {
  if (counting) ++allocations;
  void* memory = alignment <= alignof(std::max_align_t)
                     ? std::malloc(size == 0 ? 1 : size)
                     : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) std::abort();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size, 0);
}
void* operator new[](std::size_t size) {
  return allocate(size, 0);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace kerf::sheet {
namespace {

std::int64_t allocations_of(Sheet& sheet, int ticks) {
  allocations = 0;
  counting = true;
  for (int i = 0; i < ticks; ++i) sheet.step({});
  counting = false;
  return allocations;
}

// A sheet with everything switched on that acts without a command.
Sheet busy_sheet(IntegratorKind kind) {
  SheetConfig config = scenes::draped_over_sphere(12);
  config.integrator.kind = kind;
  config.pins = {std::vector<mesh::VertexId>{0, 1}};
  config.wind = {{1.0, 0.0, 0.0}, 1.2, 1.0};
  Sheet sheet = Sheet::create(config).value();
  const std::vector<Command> commands{Grab{"hand", Eigen::Vector2d(0.5, 0.9), std::nullopt, 0.0},
                                      scenes::line_cut({0.2, 0.5}, {0.8, 0.45})};
  for (const Result<CommandReply>& reply : sheet.apply(commands).replies) EXPECT_TRUE(reply.ok());
  return sheet;
}

TEST(SheetAllocation, TheGuardSeesAllocations) {
  Sheet sheet = busy_sheet(IntegratorKind::kExplicitLeapfrog);
  allocations = 0;
  counting = true;
  const std::shared_ptr<const Snapshot> snapshot = sheet.snapshot();
  counting = false;
  EXPECT_GT(allocations, 0);
}

TEST(SheetAllocation, AnExplicitTickWithoutCommandsAllocatesNothing) {
  Sheet sheet = busy_sheet(IntegratorKind::kExplicitLeapfrog);
  EXPECT_EQ(allocations_of(sheet, 100), 0);
}

TEST(SheetAllocation, AnImplicitTickWithoutCommandsAllocatesNothing) {
  Sheet sheet = busy_sheet(IntegratorKind::kImplicitEuler);
  EXPECT_EQ(allocations_of(sheet, 50), 0);
}

}  // namespace
}  // namespace kerf::sheet
