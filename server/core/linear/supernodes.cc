#include "server/core/linear/supernodes.h"

#include <algorithm>
#include <numeric>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "server/base/as_index.h"
#include "server/base/interruption.h"

namespace kerf::linear {
namespace {

// Limits of relaxed amalgamation (as CHOLMOD: Chen, Davis, Hager, Rajamanickam 2008). Supernodes that together have up
// to kAlwaysMerged columns are always merged. Larger ones are merged if explicit zeros are at most a share of their
// entries: kAllowances up to so many columns, kZerosOfLarge beyond.
constexpr int kAlwaysMerged = 4;
struct Allowance {
  int columns;
  double zeros;
};
constexpr Allowance kAllowances[] = {{16, 0.8}, {48, 0.1}};
constexpr double kZerosOfLarge = 0.05;

// Returns the number of entries in the factor of a supernode with so many columns and so many rows below them.
double entries(double columns, double below) {
  return columns * (columns + 1.0) / 2.0 + columns * below;
}

bool is_worth_merging(int columns, double zeros, double all) {
  if (columns <= kAlwaysMerged) return true;
  for (const Allowance& allowance : kAllowances) {
    if (columns <= allowance.columns) return zeros <= allowance.zeros * all;
  }
  return zeros <= kZerosOfLarge * all;
}

}  // namespace

void Supernodes::analyse(const BlockMatrix& A) {
  order(A);
  find_tree(A);
  postorder();
  count_entries(A);
  find_supernodes();
  find_rows(A);
}

void Supernodes::order(const BlockMatrix& A) {
  const int n = A.num_rows();
  Eigen::SparseMatrix<double> graph(n, n);
  graph.resizeNonZeros(A.num_blocks());
  int size = 0;
  for (int i = 0; i < n; ++i) {
    graph.outerIndexPtr()[i] = size;
    for (int at = A.row_begin(i); at < A.row_end(i); ++at) graph.innerIndexPtr()[size++] = A.column(at);
  }
  graph.outerIndexPtr()[n] = size;
  std::fill(graph.valuePtr(), graph.valuePtr() + size, 1.0);
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(graph, permutation);
  old_from_new_.assign(permutation.indices().begin(), permutation.indices().end());
  new_from_old_.resize(as_index(n));
  for (int j = 0; j < n; ++j) new_from_old_[as_index(old_from_new(j))] = j;
}

// Finds the elimination tree, shortening paths to the roots found so far (path compression; Liu 1986).
void Supernodes::find_tree(const BlockMatrix& A) {
  const int n = A.num_rows();
  tree_.assign(as_index(n), -1);
  std::vector<int> ancestor(as_index(n), -1);
  for (int i = 0; i < n; ++i) {
    const int row = old_from_new(i);
    for (int at = A.row_begin(row); at < A.row_end(row); ++at) {
      int k = new_from_old(A.column(at));
      while (k != -1 && k < i) {
        const int next = ancestor[as_index(k)];
        ancestor[as_index(k)] = i;
        if (next == -1) tree_[as_index(k)] = i;
        k = next;
      }
    }
  }
}

void Supernodes::postorder() {
  const int n = num_vertices();
  std::vector<int> head(as_index(n), -1);
  std::vector<int> next(as_index(n), -1);
  for (int j = n - 1; j >= 0; --j) {
    const int parent = tree_[as_index(j)];
    if (parent == -1) continue;
    next[as_index(j)] = head[as_index(parent)];
    head[as_index(parent)] = j;
  }
  std::vector<int> post;  // old column indices, in postorder
  post.reserve(as_index(n));
  std::vector<int> stack;
  for (int root = 0; root < n; ++root) {
    if (tree_[as_index(root)] != -1) continue;
    stack.push_back(root);
    while (!stack.empty()) {
      const int j = stack.back();
      const int child = head[as_index(j)];
      if (child == -1) {
        post.push_back(j);
        stack.pop_back();
      } else {
        head[as_index(j)] = next[as_index(child)];
        stack.push_back(child);
      }
    }
  }
  std::vector<int> place(as_index(n));
  for (int j = 0; j < n; ++j) place[as_index(post[as_index(j)])] = j;
  std::vector<int> tree(as_index(n));
  std::vector<int> old_from_new(as_index(n));
  for (int j = 0; j < n; ++j) {
    const int before = post[as_index(j)];
    const int parent = tree_[as_index(before)];
    tree[as_index(j)] = parent == -1 ? -1 : place[as_index(parent)];
    old_from_new[as_index(j)] = old_from_new_[as_index(before)];
  }
  tree_.swap(tree);
  old_from_new_.swap(old_from_new);
  for (int j = 0; j < n; ++j) new_from_old_[as_index(old_from_new_[as_index(j)])] = j;
}

// Counts by rows. The columns of row i of the factor are those on the paths of the tree from the columns of row i of A
// up to i.
void Supernodes::count_entries(const BlockMatrix& A) {
  const int n = num_vertices();
  count_.assign(as_index(n), 1);
  std::vector<int> mark(as_index(n), -1);
  for (int i = 0; i < n; ++i) {
    interruption_point();
    mark[as_index(i)] = i;
    const int row = old_from_new(i);
    for (int at = A.row_begin(row); at < A.row_end(row); ++at) {
      int k = new_from_old(A.column(at));
      if (k > i) continue;
      for (; mark[as_index(k)] != i; k = tree_[as_index(k)]) {
        mark[as_index(k)] = i;
        ++count_[as_index(k)];
      }
    }
  }
}

// Merges columns into supernodes in postorder. Each column takes in the preceding runs whose parent it is, as long as
// that adds few zeros.
void Supernodes::find_supernodes() {
  struct Run {
    int first = 0;
    int last = 0;
    double zeros = 0.0;
  };
  std::vector<Run> runs;
  for (int j = 0; j < num_vertices(); ++j) {
    Run run{j, j, 0.0};
    while (!runs.empty()) {
      const Run& before = runs.back();
      const int parent = tree_[as_index(before.last)];
      if (parent < run.first || parent > run.last) break;
      const double below = count_[as_index(run.last)] - 1;
      const int columns = run.last - before.first + 1;
      const double all = entries(columns, below);
      const double of_run = entries(run.last - run.first + 1, below) - run.zeros;
      const double of_before =
          entries(before.last - before.first + 1, count_[as_index(before.last)] - 1) - before.zeros;
      const double zeros = all - of_run - of_before;
      if (zeros > 0.0 && !is_worth_merging(columns, zeros, all)) break;
      run = {before.first, run.last, zeros};
      runs.pop_back();
    }
    runs.push_back(run);
  }
  first_.clear();
  for (const Run& run : runs) first_.push_back(run.first);
  first_.push_back(num_vertices());
}

void Supernodes::find_rows(const BlockMatrix& A) {
  const int n = num_vertices();
  std::vector<int> supernode_of(as_index(n));
  for (int s = 0; s < size(); ++s) {
    for (int j = first(s); j < first(s + 1); ++j) supernode_of[as_index(j)] = s;
  }
  parent_.assign(as_index(size()), -1);
  for (int s = 0; s < size(); ++s) {
    const int parent = tree_[as_index(first(s + 1) - 1)];
    if (parent != -1) parent_[as_index(s)] = supernode_of[as_index(parent)];
  }
  children_begin_.assign(as_index(size() + 1), 0);
  for (const int p : parent_) {
    if (p != -1) ++children_begin_[as_index(p + 1)];
  }
  std::partial_sum(children_begin_.begin(), children_begin_.end(), children_begin_.begin());
  children_.resize(as_index(children_begin_.back()));
  std::vector<int> next(children_begin_.begin(), children_begin_.end() - 1);
  for (int s = 0; s < size(); ++s) {
    if (parent(s) != -1) children_[as_index(next[as_index(parent(s))]++)] = s;
  }

  rows_begin_.assign(1, 0);
  rows_.clear();
  std::vector<int> mark(as_index(n), -1);
  for (int s = 0; s < size(); ++s) {
    interruption_point();
    const auto add = [&](int i) {
      if (i < first(s) || mark[as_index(i)] == s) return;
      mark[as_index(i)] = s;
      rows_.push_back(i);
    };
    for (int j = first(s); j < first(s + 1); ++j) add(j);
    for (int j = first(s); j < first(s + 1); ++j) {
      const int column = old_from_new(j);
      for (int at = A.row_begin(column); at < A.row_end(column); ++at) add(new_from_old(A.column(at)));
    }
    for (const int c : children(s)) {
      for (int at = rows_begin_[as_index(c)] + width(c); at < rows_begin_[as_index(c + 1)]; ++at)
        add(rows_[as_index(at)]);
    }
    std::sort(rows_.begin() + rows_begin_.back(), rows_.end());
    rows_begin_.push_back(static_cast<int>(rows_.size()));
  }

  rows_in_parent_.assign(rows_.size(), -1);
  for (int s = 0; s < size(); ++s) {
    if (parent(s) == -1) continue;
    const std::span<const int> above = rows(parent(s));
    auto place = above.begin();
    for (int at = rows_begin_[as_index(s)] + width(s); at < rows_begin_[as_index(s + 1)]; ++at) {
      place = std::find(place, above.end(), rows_[as_index(at)]);
      rows_in_parent_[as_index(at)] = static_cast<int>(place - above.begin());
    }
  }
}

}  // namespace kerf::linear
