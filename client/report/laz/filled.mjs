/** A typed array of that many scalars, of which number i is valueOf(i). Unlike Type.from, it makes no list in between. */
export function filled(Type, count, valueOf) {
  const array = new Type(count);
  for (let i = 0; i < count; i++) array[i] = valueOf(i);
  return array;
}
