#include "proto/result_columns.h"

#include <algorithm>
#include <cctype>

namespace curvature::wire {
namespace {

constexpr std::string_view kEnumPrefix = "QUANTITY_";

ResultColumn Describe(const google::protobuf::FieldDescriptor& field) {
  const v1::Column& column = field.options().GetExtension(v1::column);
  const bool is_byte = column.type() == v1::COLUMN_TYPE_UINT8;
  const size_t width = std::max<size_t>(1, column.width());
  return {field.name(),
          field.number(),
          column.quantity(),
          is_byte ? v1::COLUMN_TYPE_UINT8 : v1::COLUMN_TYPE_FLOAT32,
          width,
          width * (is_byte ? 1 : sizeof(float)),
          column.on_request()};
}

std::vector<ResultColumn> DescribeAll() {
  const google::protobuf::Descriptor& chunk = *v1::ResultChunk::descriptor();
  std::vector<ResultColumn> columns;
  for (int i = 0; i < chunk.field_count(); ++i) {
    if (chunk.field(i)->options().HasExtension(v1::column)) columns.push_back(Describe(*chunk.field(i)));
  }
  std::sort(columns.begin(), columns.end(), [](const auto& a, const auto& b) { return a.field < b.field; });
  return columns;
}

std::vector<v1::Quantity> ListQuantities() {
  const google::protobuf::EnumDescriptor& all = *v1::Quantity_descriptor();
  std::vector<v1::Quantity> quantities;
  for (int i = 0; i < all.value_count(); ++i) {
    if (all.value(i)->number() != 0) quantities.push_back(static_cast<v1::Quantity>(all.value(i)->number()));
  }
  std::sort(quantities.begin(), quantities.end());
  return quantities;
}

}  // namespace

const std::vector<ResultColumn>& ResultColumns() {
  static const auto& columns = *new std::vector<ResultColumn>(DescribeAll());
  return columns;
}

const std::vector<v1::Quantity>& Quantities() {
  static const auto& quantities = *new std::vector<v1::Quantity>(ListQuantities());
  return quantities;
}

std::string QuantityName(v1::Quantity quantity) {
  std::string name = v1::Quantity_Name(quantity);
  name.erase(0, std::min(name.size(), kEnumPrefix.size()));
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

std::optional<v1::Quantity> QuantityOf(std::string_view name) {
  const auto found = std::find_if(Quantities().begin(), Quantities().end(),
                                  [name](v1::Quantity quantity) { return QuantityName(quantity) == name; });
  if (found == Quantities().end()) return std::nullopt;
  return *found;
}

}  // namespace curvature::wire
