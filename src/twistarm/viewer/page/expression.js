// Numbers typed as expressions: sums, products, brackets, pi and units, as in 30+15, pi/4, 2*(300 mm) or 12 in.

const PARTS = /\s*((?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|[a-zπ°]+|.)/giy;
const NUMBER = /^[\d.]/;

// The value in rad or m, NaN where it is none. `units` says how many of each unit are one, `bare` how many of a number
// without one. A unit belongs to the product before it: pi/4 rad.
export function evaluated(text, units, bare) {
  const parts = [...text.trim().toLowerCase().replaceAll("−", "-").matchAll(PARTS)].map(([, part]) => part);
  const take = (...those) => (those.includes(parts[0]) ? parts.shift() : undefined);

  // Each of these gives [value, whether it has a unit].
  function factor() {
    const sign = take("-", "+");
    const [value, sized] = unsigned();
    return [sign === "-" ? -value : value, sized];
  }

  function unsigned() {
    if (take("(")) {
      const inner = sum();
      return take(")") ? inner : [NaN, false];
    }
    if (take("pi", "π")) return [Math.PI, false];
    return NUMBER.test(parts[0]) ? [Number(parts.shift()), false] : [NaN, false];
  }

  function product() {
    let [value, sized] = factor();
    for (let sign; (sign = take("*", "/", ...Object.keys(units))); ) {
      if (sign in units) {
        [value, sized] = [sized ? NaN : value / units[sign], true];
        continue;
      }
      const [by, also] = factor();
      value = also && (sized || sign === "/") ? NaN : sign === "*" ? value * by : value / by;
      sized = sized || also;
    }
    return [value, sized];
  }

  function sum() {
    const terms = [product()];
    for (let sign; (sign = take("+", "-")); ) {
      const [value, sized] = product();
      terms.push([sign === "-" ? -value : value, sized]);
    }
    const any = terms.some(([, sized]) => sized);
    return [terms.reduce((all, [value, sized]) => all + (any && !sized ? value / bare : value), 0), any];
  }

  const [value, sized] = sum();
  return parts.length > 0 ? NaN : sized ? value : value / bare;
}
