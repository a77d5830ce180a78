// Stand-in: what a writer outside the loop leaves for a reader in it.
#pragma once

namespace realtime_tools {
template <class T> class RealtimeBuffer {
  public:
    void initRT(const T& data) { data_ = data; }
    void writeFromNonRT(const T& data) { data_ = data; }
    T* readFromRT() { return &data_; }

  private:
    T data_;
};
}  // namespace realtime_tools
