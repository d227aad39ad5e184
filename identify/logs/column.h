#pragma once

/// @file
/// A column of a log: numbers that it owns, or numbers that somebody else keeps, which are then not
/// copied: the arrays of another language, or the record of another log.
///
///   Column own = std::vector<double>{0.0, 1.0};
///   const Column lent = Column::Lent(array, keeper);  // keeper outlives every copy of it
///
/// Reading is the same for both. A column that is changed owns its numbers from then on: what was
/// lent never changes. Tests: tests/identify/logs/column_test.cc.

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <ostream>
#include <span>
#include <utility>
#include <vector>

namespace lipoid {

class Column {
 public:
  using value_type = double;
  using const_iterator = const double*;

  Column() = default;
  Column(std::vector<double> numbers) : own_(std::move(numbers)) { SeeOwn(); }
  Column(std::initializer_list<double> numbers) : own_(numbers) { SeeOwn(); }
  explicit Column(std::size_t count, double number = 0.0) : own_(count, number) { SeeOwn(); }
  template <class Iterator>
  Column(Iterator begin, Iterator end) : own_(begin, end) {
    SeeOwn();
  }
  /// The numbers stay where they are, for as long as a column holds their keeper.
  [[nodiscard]] static Column Lent(std::span<const double> numbers,
                                   std::shared_ptr<const void> keeper) {
    Column column;
    column.keeper_ = std::move(keeper);
    column.data_ = numbers.data();
    column.size_ = numbers.size();
    return column;
  }

  Column(const Column& other) : own_(other.own_), keeper_(other.keeper_) { See(other); }
  Column(Column&& other) noexcept : own_(std::move(other.own_)), keeper_(std::move(other.keeper_)) {
    See(other);
    other.Forget();
  }
  Column& operator=(const Column& other) {
    if (this != &other) *this = Column(other);
    return *this;
  }
  Column& operator=(Column&& other) noexcept {
    if (this == &other) return *this;
    own_ = std::move(other.own_);
    keeper_ = std::move(other.keeper_);
    See(other);
    other.Forget();
    return *this;
  }
  ~Column() = default;

  [[nodiscard]] bool lent() const { return keeper_ != nullptr; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] const double* data() const { return data_; }
  [[nodiscard]] const double& operator[](std::size_t k) const { return data_[k]; }
  [[nodiscard]] const double& front() const { return data_[0]; }
  [[nodiscard]] const double& back() const { return data_[size_ - 1]; }
  [[nodiscard]] const double* begin() const { return data_; }
  [[nodiscard]] const double* end() const { return data_ + size_; }
  [[nodiscard]] auto rbegin() const { return std::make_reverse_iterator(end()); }
  [[nodiscard]] auto rend() const { return std::make_reverse_iterator(begin()); }
  operator std::span<const double>() const { return {data_, size_}; }
  [[nodiscard]] std::vector<double> ToVector() const { return {begin(), end()}; }

  // What changes the column. A number that is asked for by a name that may change it is copied
  // first where it was lent: hand a record on as const.
  [[nodiscard]] double& operator[](std::size_t k) { return Own()[k]; }
  [[nodiscard]] double& front() { return Own().front(); }
  [[nodiscard]] double& back() { return Own().back(); }
  [[nodiscard]] double* begin() { return Own().data(); }
  [[nodiscard]] double* end() { return Own().data() + size_; }
  [[nodiscard]] std::size_t capacity() const { return own_.capacity(); }
  void reserve(std::size_t count) {
    Change([&](auto& own) { own.reserve(count); });
  }
  void resize(std::size_t count) {
    Change([&](auto& own) { own.resize(count); });
  }
  void clear() { *this = Column(); }
  void push_back(double number) {
    Change([&](auto& own) { own.push_back(number); });
  }
  template <class Iterator>
  void append(Iterator first, Iterator last) {
    Change([&](auto& own) { own.insert(own.end(), first, last); });
  }

  friend bool operator==(const Column& a, const Column& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }
  friend std::ostream& operator<<(std::ostream& stream, const Column& column) {
    stream << "{";
    for (const double number : column) stream << " " << number;
    return stream << " }";
  }

 private:
  std::vector<double>& Own() {
    if (lent()) {
      own_.assign(data_, data_ + size_);
      keeper_.reset();
      SeeOwn();
    }
    return own_;
  }
  template <class What>
  void Change(What&& what) {
    what(Own());
    SeeOwn();
  }
  void SeeOwn() {
    data_ = own_.data();
    size_ = own_.size();
  }
  void See(const Column& other) {
    data_ = lent() ? other.data_ : own_.data();
    size_ = other.size_;
  }
  void Forget() {
    own_.clear();
    keeper_.reset();
    SeeOwn();
  }

  std::vector<double> own_;
  std::shared_ptr<const void> keeper_;
  const double* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace lipoid
