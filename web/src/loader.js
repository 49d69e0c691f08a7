// Unpacks the program when the whole page is there, and runs it.
addEventListener("DOMContentLoaded", async () => {
  const say = (words) => {
    document.getElementById("fault").textContent = words;
    document.body.dataset.state = "fault";
  };
  addEventListener("error", (event) => say(`This page failed: ${event.message}`));
  try {
    const text = document.getElementById("program").textContent;
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
  } catch {
    say("This browser cannot unpack the page. Chrome 103, Firefox 113, Safari 16.4 and later can; or the file is damaged.");
  }
});
