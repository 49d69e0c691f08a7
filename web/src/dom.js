// Elements from words: text is never read as markup.

/** An element with properties, and children that are elements or texts. */
export function el(name, properties = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key === "data") Object.assign(element.dataset, value);
    else if (key.includes("-") || key === "role" || key === "for") element.setAttribute(key, value);
    else element[key] = value;
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** The same of a picture. */
export function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** Minutes and seconds, cut as a clock shows them: 59.9 s are 0:59. */
export function minutes(seconds, digits = 0) {
  const scale = 10 ** digits;
  // Times of cycles may be slightly less than the second by rounding.
  const all = Math.floor((Math.max(0, seconds) + 1e-4) * scale);
  const rest = (all % (60 * scale)) / scale;
  return `${Math.floor(all / (60 * scale))}:${rest.toFixed(digits).padStart(digits ? 3 + digits : 2, "0")}`;
}
